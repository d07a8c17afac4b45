"""The neural controller of a MarxBot and its genome; plain Python, NumPy and Numba."""
