"""The three-way merge of a block, and who wrote each of its values."""
