// Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
#ifndef SUBSCRIBE_CPP__STIFFNESS_TEXT_HPP_
#define SUBSCRIBE_CPP__STIFFNESS_TEXT_HPP_

#include <cmath>
#include <cstdio>
#include <string>

#include "vsa_msgs/msg/joint_impedance.hpp"

namespace subscribe_cpp
{

/// Stiffness [N m/rad] with the half-width of its 95 % interval; empty while it is not valid.
inline std::string stiffness_text(const vsa_msgs::msg::JointImpedance & joint)
{
  if (!joint.stiffness_valid) {
    return "";
  }
  char text[80];
  const double half_width = 1.96 * std::sqrt(joint.stiffness_variance);
  std::snprintf(text, sizeof(text), "K = %.3f +- %.3f N m/rad", joint.stiffness, half_width);
  return text;
}

}  // namespace subscribe_cpp

#endif  // SUBSCRIBE_CPP__STIFFNESS_TEXT_HPP_
