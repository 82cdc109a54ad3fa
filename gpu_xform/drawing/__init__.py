"""Pictures as data: layers and a camera become a draw list, which any back end draws."""
