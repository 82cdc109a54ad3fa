"""Subcommands, one per module: each has USAGE, DESCRIPTION, EPILOG, `add_options(parser)` and `run(options)`.

`run` returns the exit code. A module is imported when its command is chosen.

Reading order: render, animate, simulate, view, transform, convolve, info, explain, doctor, bench, completion.
"""

SUMMARIES = {
    "render": "draw models as PNG, SVG or PDF",
    "animate": "draw moving models as a GIF, video or web page",
    "simulate": "let cloth or hair fall or hang, and draw it as a GIF, video or web page",
    "view": "show models in an interactive window",
    "transform": "transform the points of model files, arrays or scans",
    "convolve": "convolve an image with a kernel",
    "info": "print what model files hold",
    "explain": "print the matrices of a transform",
    "doctor": "check the graphics adapter and its driver",
    "bench": "measure the speed of bulk transforms",
    "completion": "print a script that completes options in a shell",
}
