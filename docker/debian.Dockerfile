# A Debian with Python and without ROS. From the clone's root: docker build -f docker/debian.Dockerfile -t vsa .

FROM python:3.12-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends g++ git && rm -rf /var/lib/apt/lists/*
WORKDIR /vsa
COPY . .
RUN ./vsa setup
ENTRYPOINT ["/vsa/docker/entrypoint.sh"]
CMD ["bash"]
