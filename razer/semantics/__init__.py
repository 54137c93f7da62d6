"""Classes, gravity and relations of instances."""
