"""Models of many fault and event trees, as Open-PSA and OpenPRA files hold them."""
