// A regular grid of points, kept block by block of four columns, and its springs.
struct GridSprings {
    along_row: vec2<f32>, // stiffness (N/m), and stiffness times rest length (N): to the next point of the row
    over_row: vec2<f32>, // to the next but one
    along_column: vec2<f32>,
    over_column: vec2<f32>,
    shear: vec2<f32>, // across a cell
    height: u32, // rows
    width: u32, // columns
    row_shift: u32, // points from one row to the next
    column_shift: u32,
    n_blocks: u32, // of four columns
    n_strips: u32, // of rows
    n_padded_rows: u32, // with two empty ones at either end; so has a row an empty block at either end
}
