// Neighbours of a row of an image: a block of four vectors, and the strip of one more that the taps of a block meet.
#import real

struct Block {
    a: Vec4,
    b: Vec4,
    c: Vec4,
    d: Vec4,
}

struct Strip {
    a: Vec4,
    b: Vec4,
    c: Vec4,
    d: Vec4,
    e: Vec4,
}

fn slide(s: Strip, next: Vec4) -> Strip {
    return Strip(s.b, s.c, s.d, s.e, next);
}

// A strip of numbers that begins one, two or three of them later; its last vector is of no use.
fn shift_by_one(s: Strip) -> Strip {
    return Strip(Vec4(s.a.yzw, s.b.x), Vec4(s.b.yzw, s.c.x), Vec4(s.c.yzw, s.d.x), Vec4(s.d.yzw, s.e.x), s.e);
}

fn shift_by_two(s: Strip) -> Strip {
    return Strip(Vec4(s.a.zw, s.b.xy), Vec4(s.b.zw, s.c.xy), Vec4(s.c.zw, s.d.xy), Vec4(s.d.zw, s.e.xy), s.e);
}

fn shift_by_three(s: Strip) -> Strip {
    return Strip(Vec4(s.a.w, s.b.xyz), Vec4(s.b.w, s.c.xyz), Vec4(s.c.w, s.d.xyz), Vec4(s.d.w, s.e.xyz), s.e);
}

fn add_tap(sum: Block, s: Strip, coefficient: Real) -> Block {
    let k = Vec4(coefficient);
    return Block(fma(k, s.a, sum.a), fma(k, s.b, sum.b), fma(k, s.c, sum.c), fma(k, s.d, sum.d));
}

fn add_blocks(s: Block, t: Block) -> Block {
    return Block(s.a + t.a, s.b + t.b, s.c + t.c, s.d + t.d);
}
