"""The MarxBot, its arena and its senses; plain Python, NumPy and Numba."""
