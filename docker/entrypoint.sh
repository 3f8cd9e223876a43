#!/usr/bin/env bash
# Runs the container's command in the environment of the suite.
set -e
if [ -f /opt/ros/jazzy/setup.bash ]; then source /opt/ros/jazzy/setup.bash; fi
eval "$(/vsa/vsa env)"
exec "$@"
