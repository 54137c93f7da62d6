"""Floor plans: rooms, and the placement of furniture in them."""
