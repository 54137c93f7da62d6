"""Parts of tracked things: what masks within the masks of a whole show view after view, such as the seat of a chair."""
