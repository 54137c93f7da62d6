"""Surfaces against the true one."""
