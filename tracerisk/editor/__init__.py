"""What an editor shows of risk blocks: a language server over standard input and output."""
