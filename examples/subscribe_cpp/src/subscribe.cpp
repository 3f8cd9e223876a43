// Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>

#include "rclcpp/rclcpp.hpp"
#include "subscribe_cpp/stiffness_text.hpp"
#include "vsa_msgs/msg/joint_impedance.hpp"

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  auto node = std::make_shared<rclcpp::Node>("controller");
  auto subscription = node->create_subscription<vsa_msgs::msg::JointImpedance>(
    "/vsa/joint_impedance", 10,
    [](const vsa_msgs::msg::JointImpedance & joint) {
      const std::string text = subscribe_cpp::stiffness_text(joint);
      if (!text.empty()) {
        std::puts(text.c_str());
      }
    });
  rclcpp::spin(node);
  rclcpp::shutdown();
  return 0;
}
