"""A page for the browser that simulates: the kernel itself, as WebAssembly, with controls."""
