/* aba.cpp: seconds a call of Pinocchio's ABA on the crane with rigid joints. */
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/multibody.hpp>

#include <algorithm>
#include <chrono>

namespace pin = pinocchio;
using Eigen::Vector3d;

namespace {

pin::Inertia inertia(double mass, const Vector3d &com, const Vector3d &about_com) {
    return pin::Inertia(mass, com, about_com.asDiagonal().toDenseMatrix());
}

pin::SE3 at(const Vector3d &place) { return pin::SE3(Eigen::Matrix3d::Identity(), place); }

pin::Model crane() {
    pin::Model model;
    const auto hull = model.addJoint(0, pin::JointModelFreeFlyer(), pin::SE3::Identity(), "hull");
    model.appendBodyToJoint(hull, inertia(1e5, {0, 0, 0}, {7e5, 3.6e6, 4.1e6}));
    const auto slew = model.addJoint(hull, pin::JointModelRZ(), at({2, 0, 1.5}), "slew");
    model.appendBodyToJoint(slew, inertia(5e3, {0, 0, 2}, {7.5e3, 7.5e3, 1.5e3}));
    const auto luff = model.addJoint(slew, pin::JointModelRY(), at({0, 0, 4}), "luff");
    model.appendBodyToJoint(luff, inertia(3e3, {4, 0, 0}, {4e2, 1.65e4, 1.65e4}));
    const auto fold = model.addJoint(luff, pin::JointModelRY(), at({8, 0, 0}), "fold");
    model.appendBodyToJoint(fold, inertia(1.5e3, {3, 0, 0}, {1.2e2, 4.6e3, 4.6e3}));
    return model;
}

} // namespace

/* The least of several batches. q: place, quaternion x y z w, angles; a: accelerations. */
extern "C" double aba_seconds(const double *q0, const double *v0, int calls, int batches,
                              double *a) {
    const pin::Model model = crane();
    pin::Data data(model);
    Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(q0, model.nq);
    const Eigen::VectorXd v = Eigen::Map<const Eigen::VectorXd>(v0, model.nv);
    const Eigen::VectorXd tau = Eigen::VectorXd::Zero(model.nv);
    double best = 1e9;

    for (int batch = 0; batch < batches; batch++) {
        const auto start = std::chrono::steady_clock::now();
        for (int k = 0; k < calls; k++) {
            q[8] = q0[8] + 1e-12 * k;
            pin::aba(model, data, q, v, tau, pin::Convention::LOCAL);
        }
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
        best = std::min(best, spent.count() / calls);
    }
    Eigen::Map<Eigen::VectorXd>(a, model.nv) = data.ddq;
    return best;
}
