"""One scene with several contact laws: the comparison of the laws, its text and its picture."""
