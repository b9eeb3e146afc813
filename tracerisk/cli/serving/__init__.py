"""The pages of `tracerisk serve`, and the server of them."""
