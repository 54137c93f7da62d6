"""The map over HTTP: routes, who may ask what, streams of events, the server itself."""
