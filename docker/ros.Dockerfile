# ROS 2 Jazzy on Ubuntu 24.04. From the clone's root: docker build -f docker/ros.Dockerfile -t vsa .

# Everything from apt. .devcontainer/ stops here.
FROM ros:jazzy AS tools
SHELL ["/bin/bash", "-c"]
COPY src /tmp/src
RUN apt-get update \
    && apt-get install -y --no-install-recommends g++ git python3-colcon-common-extensions python3-dev python3-venv \
    && rosdep update --rosdistro jazzy \
    && rosdep install --from-paths /tmp/src --ignore-src -y --skip-keys "python3-cantools-pip python3-filterpy-pip python3-rosbags-pip" \
    && rm -rf /var/lib/apt/lists/* /tmp/src

# The environment, the build, and a shell in it.
FROM tools AS suite
WORKDIR /vsa
COPY . .
RUN source /opt/ros/jazzy/setup.bash && ./vsa setup
ENTRYPOINT ["/vsa/docker/entrypoint.sh"]
CMD ["bash"]
