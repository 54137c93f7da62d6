"""RAZER: an RGB-D recording becomes a map of named, queryable instances."""
