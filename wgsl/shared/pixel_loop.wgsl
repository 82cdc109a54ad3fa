// Goes through the pixels of a tile that `is_marked` says yes to, and draws `color_at_mark`, premultiplied, over them.
#import composite

fn scan(first: u32, stride: u32) {
    let n = n_pixels();
    let background = pack4x8unorm(tile.background);
    var index = first;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, what is skipped in step costs as much as what is done.
        while index < n && !is_marked(index) {
            if is_first {
                picture[index] = background;
            }
            index += stride;
        }
        if index >= n {
            break;
        }
        draw_over(index, color_at_mark(index));
        index += stride;
    }
}
