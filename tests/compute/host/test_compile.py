"""Compiled loops under one lock: threads of Python and of numba, forked children, folders that cannot be written."""

import pytest

from tests.support.python_run import linux_only, python_output, run_python

BYTES = """
    import hashlib, os, sys
    import numpy as np
    import gpu_xform as gx
    host = gx.Device("host")
    matrix = gx.chain(gx.scale(0.3), gx.rotate((1, 2, 3), 1.0), gx.translate(1, 2, 3))

    def digest():
        rng, found = np.random.default_rng(0), hashlib.sha256()
        for dtype in (np.float32, np.float64):
            points = rng.normal(size=(100_003, 3)).astype(dtype)
            with gx.PointBuffer(points, device=host) as buffer:
                for result in (
                    gx.transform_points(points, matrix, device=host),
                    gx.transform_vectors(points, matrix, normalize=True, device=host),
                    buffer.transformed(matrix).bounds(),
                    buffer.transformed(matrix).centroid(),
                ):
                    found.update(result.tobytes())
        return found.hexdigest()

    for os.environ["GPU_XFORM_THREADS"] in ("", "1", "999"):
        print(digest())
"""


def test_the_number_of_threads_changes_no_byte() -> None:
    digests = [*python_output(BYTES).split(), *python_output(BYTES, NUMBA_NUM_THREADS="1").split()]
    assert len(digests) == 6
    assert len(set(digests)) == 1


def test_a_limit_of_threads_holds_for_our_loops_alone() -> None:
    code = """
        import numba
        import numpy as np
        import gpu_xform as gx
        numba.set_num_threads(2)
        gx.transform_points(np.ones((20_000, 3)), gx.identity(), device=gx.Device("host"))
        print(numba.get_num_threads())
    """
    assert python_output(code, GPU_XFORM_THREADS="1", NUMBA_NUM_THREADS="2") == "2\n"


@pytest.mark.parametrize("layer", ["default", "workqueue"])
def test_eight_threads_compute_at_once(layer: str) -> None:
    code = """
        import threading
        import numpy as np
        import gpu_xform as gx
        host = gx.Device("host")
        points = np.random.default_rng(0).normal(size=(50_000, 3))
        right = []

        def work(offset):
            matrix = gx.translate(offset, 0, 0)
            for _ in range(20):
                result = gx.transform_points(points, matrix, device=host)
            right.append(bool((result[:, 0] == points[:, 0] + offset).all()))

        threads = [threading.Thread(target=work, args=(k,)) for k in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        print(right.count(True))
    """
    assert python_output(code, NUMBA_THREADING_LAYER=layer, NUMBA_NUM_THREADS="2") == "8\n"


@linux_only
def test_a_fork_is_told_so_and_computes_few_points() -> None:
    code = """
        import os, sys
        import numpy as np
        import gpu_xform as gx
        host = gx.Device("host")
        points = np.ones((20_000, 3))
        gx.transform_points(points, gx.identity(), device=host)
        child = os.fork()
        if child == 0:
            print(gx.transform_points(points[:2], gx.translate(1, 0, 0), device=host).tolist())
            try:
                gx.transform_points(points, gx.identity(), device=host)
            except gx.DeviceError as error:
                print(error)
            sys.stdout.flush()
            os._exit(0)
        os.waitpid(child, 0)
        print(gx.transform_points(points, gx.identity(), device=host)[0].tolist())
    """
    few, error, parent = python_output(code).splitlines()
    assert few == "[[2.0, 1.0, 1.0], [2.0, 1.0, 1.0]]"
    assert "is a fork of process" in error
    assert "multiprocessing.get_context('spawn')" in error
    assert parent == "[1.0, 1.0, 1.0]"


@linux_only
def test_a_child_forked_before_the_first_loop_computes() -> None:
    code = """
        import os, sys
        import numpy as np
        import gpu_xform as gx
        host = gx.Device("host")
        gx.transform_points(np.ones((5, 3)), gx.identity(), device=host)
        child = os.fork()
        if child == 0:
            print(gx.transform_points(np.ones((20_000, 3)), gx.identity(), device=host)[0].tolist())
            sys.stdout.flush()
            os._exit(0)
        print(os.waitpid(child, 0)[1])
    """
    assert python_output(code).splitlines() == ["[1.0, 1.0, 1.0]", "0"]


def test_without_a_folder_to_cache_in_each_process_compiles_for_itself() -> None:
    code = """
        import numpy as np
        import gpu_xform as gx
        print(gx.transform_points(np.ones((20_000, 3)), gx.scale(2), device=gx.Device("host"))[0].tolist())
    """
    assert python_output(code, NUMBA_CACHE_DIR="/dev/null/cache") == "[2.0, 2.0, 2.0]\n"


def test_the_threads_must_be_a_positive_whole_number() -> None:
    for text in ("0", "-1", "1.5", "two"):
        result = run_python("import gpu_xform as gx; gx.Device('host')", GPU_XFORM_THREADS=text)
        last = result.stderr.splitlines()[-1]
        assert last.endswith(f"ArgumentError: GPU_XFORM_THREADS must be a positive whole number, got {text!r}")
