/* arm.cpp: seconds a call of Pinocchio's algorithms on an arm or a tree of boxes on hinges. */
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/multibody.hpp>

#include <algorithm>
#include <string>

extern "C" double clock_now(void);

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/* The mechanism: of box k the parent (-1: the ground), the axis (0, 1, 2) and the mass. */
pin::Model mechanism(int count, const int *parent, const int *axis, const double *mass, double link,
                     const double *com, const double *inertia) {
    pin::Model model;
    const Matrix3d about_com = Eigen::Map<const Matrix3d>(inertia);

    for (int k = 0; k < count; k++) {
        const Vector3d place(parent[k] >= 0 ? link : 0.0, 0.0, 0.0);
        const pin::SE3 mount(Matrix3d::Identity(), place);
        const pin::JointIndex before = parent[k] >= 0 ? parent[k] + 1 : 0;
        const std::string name = "joint" + std::to_string(k);
        const pin::Inertia body(mass[k], Eigen::Map<const Vector3d>(com), about_com);
        const pin::JointIndex made =
            axis[k] == 0   ? model.addJoint(before, pin::JointModelRX(), mount, name)
            : axis[k] == 1 ? model.addJoint(before, pin::JointModelRY(), mount, name)
                           : model.addJoint(before, pin::JointModelRZ(), mount, name);
        model.appendBodyToJoint(made, body);
    }
    return model;
}

} // namespace

/* Writes the accelerations a at (q0, v0) with friction, and the least seconds, over several batches, of a
 * call of the forward dynamics and of its derivatives by q, v and the torques. */
extern "C" void arm_seconds(int count, const int *parent, const int *axis, const double *mass,
                            double link, const double *com, const double *inertia, double friction,
                            const double *q0, const double *v0, int calls, int batches, double *a,
                            double seconds[2]) {
    const pin::Model model = mechanism(count, parent, axis, mass, link, com, inertia);
    pin::Data data(model);
    Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(q0, count);
    const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(v0, count);
    Eigen::VectorXd torque(count);

    seconds[0] = seconds[1] = 1e9;
    for (int batch = 0; batch < batches; batch++) {
        double start = clock_now(), middle;
        for (int k = 0; k < calls; k++) {
            q[0] = q0[0] + 1e-12 * k;
            torque.noalias() = -friction * v;
            pin::aba(model, data, q, v, torque, pin::Convention::LOCAL);
        }
        middle = clock_now();
        seconds[0] = std::min(seconds[0], (middle - start) / calls);
        Eigen::Map<Eigen::VectorXd>(a, count) = data.ddq;
        for (int k = 0; k < calls; k++) {
            q[0] = q0[0] + 1e-12 * k;
            pin::computeABADerivatives(model, data, q, v, torque);
        }
        seconds[1] = std::min(seconds[1], (clock_now() - middle) / calls);
    }
}
