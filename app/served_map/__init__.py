"""One opened map that many ask at once: what the HTTP interface and the tools for agents answer from."""
