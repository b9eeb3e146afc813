"""Topics that command joints, and the streams of set-points on them."""
