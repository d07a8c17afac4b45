"""What a lidar and a camera see, as a MarxBot would sense it; plain Python and NumPy."""
