// Windows of pixels, two cells wide and high, one at each cell, and the farthest depth of the faces in each. What
// is behind it is hidden in all of the window: Greene et al., "Hierarchical Z-buffer visibility", 1993.
#import tile

const CELL_PX = 4;

fn cell_counts(tile: Tile) -> vec2<i32> {
    return (tile.depth_extent + (CELL_PX - 1)) / CELL_PX;
}
