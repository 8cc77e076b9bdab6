"""One scene with several contact laws: the comparison of the laws and its text."""
