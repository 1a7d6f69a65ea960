// A needle as Fortmeier-2016 simulates it: one rigid body a node, each joined to the next by a ball
// joint and a rotational spring, in the rigid-body engine Bullet with its projected Gauss-Seidel
// solver and steps of 1 ms. For comparison only.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <memory>
#include <vector>

namespace acus::bench {

/// The spring acts with torque, as explicit springs must: bodies have to be heavy for the step to
/// be stable, and the chain then is slow to come to rest. Mass, inertia and damping below are the
/// best of a search over 384 settings for the fewest microseconds to 1 % at 25 nodes; for
/// other numbers of nodes they follow the limit of stability (mass with nodes^3, inertia with
/// nodes).
struct ChainOptions {
  int num_nodes = 25;
  double length_m = 0.150;
  double spring_n_m = 0.0;  ///< Of each joint, N m per rad; EI / spacing is the physical one.
  double mass_kg = 0.1;
  double inertia_kg_m2 = 1e-5;
  double damping_per_s = 15.0;
  int solver_iterations = 4;
};

inline ChainOptions ScaledTo(int num_nodes, double spring_n_m) {
  ChainOptions options;
  const double finer = (num_nodes - 1) / 24.0;
  options.num_nodes = num_nodes;
  options.spring_n_m = spring_n_m;
  if (finer > 1.0) {
    options.mass_kg *= finer * finer * finer;
    options.inertia_kg_m2 *= finer;
    options.damping_per_s /= finer * finer;
  }
  return options;
}

class BulletChain {
 public:
  explicit BulletChain(const ChainOptions& options)
      : options_(options), world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity({0, 0, 0});
    world_.getSolverInfo().m_numIterations = options.solver_iterations;
    world_.getSolverInfo().m_solverMode = SOLVER_USE_WARMSTARTING;
    const double spacing_m = options.length_m / (options.num_nodes - 1);
    for (int i = 0; i < options.num_nodes; ++i) AddBody(i, spacing_m);
    const btVector3 half(0, 0, static_cast<btScalar>(0.5 * spacing_m));
    for (int i = 0; i + 1 < options.num_nodes; ++i) {
      joints_.push_back(
          std::make_unique<btPoint2PointConstraint>(*bodies_[i], *bodies_[i + 1], half, -half));
      world_.addConstraint(joints_.back().get(), true);
    }
  }
  ~BulletChain() {
    for (auto& joint : joints_) world_.removeConstraint(joint.get());
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  BulletChain(const BulletChain&) = delete;
  BulletChain& operator=(const BulletChain&) = delete;

  void SetTipForce(double force_n) { force_n_ = static_cast<btScalar>(force_n); }
  double TipMm() const { return 1e3 * bodies_.back()->getCenterOfMassPosition().x(); }

  /// One step of 1 ms of the engine.
  void Substep() {
    bodies_.back()->applyCentralForce({force_n_, 0, 0});
    const auto spring = static_cast<btScalar>(2.0 * options_.spring_n_m);
    for (std::size_t i = 0; i + 1 < bodies_.size(); ++i) {
      btQuaternion turn = bodies_[i + 1]->getOrientation() * bodies_[i]->getOrientation().inverse();
      if (turn.w() < 0) turn = -turn;
      const btVector3 torque = spring * btVector3(turn.x(), turn.y(), turn.z());
      bodies_[i + 1]->applyTorque(-torque);
      if (i > 0) bodies_[i]->applyTorque(torque);
    }
    world_.stepSimulation(btScalar(1e-3), 0, btScalar(1e-3));
  }

 private:
  void AddBody(int i, double spacing_m) {
    const bool held = i == 0;
    const auto inertia = static_cast<btScalar>(held ? 0.0 : options_.inertia_kg_m2);
    btRigidBody::btRigidBodyConstructionInfo info(
        static_cast<btScalar>(held ? 0.0 : options_.mass_kg), nullptr, &shape_,
        {inertia, inertia, inertia});
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin({0, 0, static_cast<btScalar>(i * spacing_m)});
    // Bullet's damping is the share of the speed lost in 1 s.
    info.m_linearDamping = static_cast<btScalar>(1.0 - std::exp(-options_.damping_per_s));
    info.m_angularDamping = info.m_linearDamping;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get(), 0, 0);  // Touches nothing.
  }

  ChainOptions options_;
  btSphereShape shape_{btScalar(5e-4)};
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  btScalar force_n_ = 0;
};

}  // namespace acus::bench
