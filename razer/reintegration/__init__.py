"""Reintegration (BundleFusion): kept frames are integrated anew at corrected poses."""
