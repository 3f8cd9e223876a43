#!/usr/bin/env bash
# The suite's quantities in rqt_plot, a view at a time: ./rqt_plot.sh VIEW [NAMESPACE]
set -euo pipefail
view=${1:-}
ns=${2:-/vsa}
one=$ns/transmission_1
two=$ns/transmission_2
joint=$ns/joint_impedance

case $view in
  force) fields="$one/impedance/force $two/impedance/force" ;;
  position) fields="$one/impedance/deflection $two/impedance/deflection" ;;
  velocity) fields="$one/impedance/velocity $two/impedance/velocity" ;;
  stiffness) fields="$one/impedance/stiffness $two/impedance/stiffness" ;;
  damping) fields="$one/impedance/damping $two/impedance/damping" ;;
  inertia) fields="$one/impedance/inertia $two/impedance/inertia" ;;
  k2) fields="$one/estimator_state/k2 $two/estimator_state/k2" ;;
  d2) fields="$one/estimator_state/d2 $two/estimator_state/d2" ;;
  joint) fields="$joint/stiffness $joint/damping" ;;
  tension) fields="$joint/tension[0] $joint/tension[1] $joint/co_contraction" ;;
  status) fields="$one/impedance/status $two/impedance/status $joint/status" ;;
  *)
    echo "usage: rqt_plot.sh force|position|velocity|stiffness|damping|inertia|k2|d2|joint|tension|status [NAMESPACE]" >&2
    exit 2
    ;;
esac
# shellcheck disable=SC2086
exec ros2 run rqt_plot rqt_plot $fields
