"""Ablation studies: mappers and queries with one part changed."""
