"""How wrong poses may be: covariances, and directions that nothing in view fixes."""
