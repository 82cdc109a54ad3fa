"""Arrays in, arrays out, computed on the device: transforms, point buffers, files of points."""
