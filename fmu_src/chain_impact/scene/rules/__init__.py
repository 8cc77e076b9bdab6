"""The rules of single keys, and the language of rules that combine keys."""
