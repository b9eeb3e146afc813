"""Where figures come from, as text to be checked with a calculator."""
