# The command gpu-xform with lavapipe, which draws without a GPU:
#     docker build --tag gpu-xform .
#     docker run --rm --user "$(id -u)" --volume "$PWD:/work" gpu-xform render models --sheet sheet.png
FROM python:3.12-slim-bookworm AS build
COPY . /source
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels /source

FROM python:3.12-slim-bookworm
# Debian's version of the release, whatever it is at the time: the pictures are the same within the stated tolerance.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install -y --no-install-recommends libvulkan1 mesa-vulkan-drivers \
    && rm -rf /var/lib/apt/lists/*
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels pip install --no-cache-dir "$(echo /wheels/*.whl)[3mf,cad,gltf,robots]"
# A user without a home, as of --user, still has a place for caches and the driver's temporary files.
ENV HOME=/tmp XDG_RUNTIME_DIR=/tmp
WORKDIR /work
ENTRYPOINT ["gpu-xform"]
CMD ["--help"]
