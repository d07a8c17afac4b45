# Both commands of the README, ready to run:
#   docker build -t red-queen .
#   docker run --init --rm -it --shm-size 512m -v "$PWD/runs:/red-queen/runs" red-queen \
#       scripts/ros2 run coevo_manager evolve
#   docker run --init --rm -it --shm-size 512m red-queen scripts/test
FROM debian:12-slim

RUN apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        build-essential ca-certificates chromium chromium-driver git \
        python3 python3-dev python3-venv \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /red-queen
COPY . .
RUN scripts/setup

CMD ["scripts/ros2", "run", "coevo_manager", "evolve"]
