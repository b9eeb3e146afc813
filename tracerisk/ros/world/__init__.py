"""What of a world lies between a controller and the cell around it."""
