// The viewer's view of samples, sound ones and others, without a bus.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "idl/particle_frame.h"
#include "tests/support/seed.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/feed_state.h"
#include "viewer/session.h"

namespace palp::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

SceneDescription scene_of(std::uint64_t session, std::uint32_t particles) {
  SceneDescription scene;
  scene.header.session = session;
  scene.scene_hash = session;
  scene.particle_count = particles;
  scene.spacing = 0.01;
  scene.bounds_max = {1, 1, 1};
  return scene;
}

std::vector<ParticleChunk> chunks(std::uint64_t session, std::uint64_t number, std::uint32_t particles) {
  std::vector<ParticleChunk> out;
  for (std::uint32_t i = 0; i < chunks_of(particles); ++i) {
    ParticleChunk chunk;
    chunk.header.session = session;
    chunk.header.t_send_ns = static_cast<std::int64_t>(number) * kMs;
    chunk.frame = number;
    chunk.sim_time = 1e-3 * static_cast<double>(number);
    chunk.chunk = i;
    chunk.chunk_count = chunks_of(particles);
    chunk.first = i * kChunkParticles;
    chunk.particle_count = particles;
    chunk.positions.assign(3u * particles_in_chunk(particles, i), 0.5f);
    out.push_back(chunk);
  }
  return out;
}

void feed(FeedState& state, const std::vector<ParticleChunk>& frame) {
  for (const ParticleChunk& chunk : frame) state.add({chunk, chunk.header.t_send_ns + kMs});
}

TEST(FeedState, ShowsTheNewestCompleteFrameAndCountsTheLost) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 9000), 0});
  feed(state, chunks(5, 1, 9000));
  ASSERT_TRUE(state.view().frame);
  EXPECT_EQ(state.view().frame->frame, 1u);
  EXPECT_EQ(state.view().frame_time_ns, 1 * kMs);
  std::vector<ParticleChunk> torn = chunks(5, 2, 9000);
  torn.pop_back();
  feed(state, torn);
  EXPECT_EQ(state.view().frame->frame, 1u);
  feed(state, chunks(5, 4, 9000));
  EXPECT_EQ(state.view().frame->frame, 4u);
  EXPECT_EQ(state.view().lost_frames, 2u);
  EXPECT_EQ(state.view().frames, 2u);
}

TEST(FeedState, AgeCountsFromReceiptWhenTheSenderIsOnAnotherHost) {
  FeedState state(false, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  feed(state, chunks(5, 7, 10));
  EXPECT_EQ(state.view().frame_time_ns, 8 * kMs);
}

TEST(FeedState, AgeCountsFromReceiptWhenTheStampCannotBe) {
  constexpr std::int64_t kReceived = 5000 * kMs;
  using Limits = std::numeric_limits<std::int64_t>;
  for (const std::int64_t sent :
       {Limits::min(), Limits::max(), std::int64_t{0}, kReceived + 1, kReceived - 3000 * kMs}) {
    FeedState state(true, 1);
    state.add(Received<SceneDescription>{scene_of(5, 10), 0});
    ParticleChunk chunk = chunks(5, 7, 10).front();
    chunk.header.t_send_ns = sent;
    state.add({chunk, kReceived});
    EXPECT_EQ(state.view().frame_time_ns, kReceived) << sent;
  }
}

TEST(FeedState, FramesMayComeBeforeTheirScene) {
  FeedState state(true, 1);
  feed(state, chunks(5, 1, 10));
  EXPECT_FALSE(state.view().frame);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  EXPECT_TRUE(state.view().frame);
}

// Nothing is heard of anybody for a while; returns when it ends.
std::int64_t stay_silent(FeedState& state, std::int64_t from_ns, int ms) {
  for (int i = 0; i <= ms; i += 10) state.forget(from_ns + i * kMs);
  return from_ns + ms * kMs;
}

Status server_status(std::uint64_t session, const std::string& state_name, double pid) {
  Status status;
  status.process = kServerName;
  status.header.session = session;
  status.state = state_name;
  status.metrics = {{"pid_on_lab3", pid}};
  return status;
}

TEST(FeedState, HoldsOnToOneOfTwoServersAndSaysSo) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  state.add(Received<SceneDescription>{scene_of(6, 20), 0});
  BodyPoses poses;
  ProxySample proxy;
  for (int i = 0; i < 200; ++i) {
    const std::int64_t now = i * 10 * kMs;
    const std::uint64_t number = static_cast<std::uint64_t>(i) + 1;
    for (const std::uint64_t session : {5u, 6u}) {
      ParticleChunk chunk = chunks(session, number, session == 5 ? 10 : 20).front();
      state.add({chunk, now});
      poses.header.session = proxy.header.session = session;
      poses.sim_time = proxy.sim_time = static_cast<double>(session);
      state.add(Received<BodyPoses>{poses, now});
      state.add(Received<ProxySample>{proxy, now});
      state.add(Received<Status>{server_status(session, "running", static_cast<double>(session)), now});
    }
    state.forget(now);
    ASSERT_TRUE(state.view().frame);
    ASSERT_EQ(state.view().scene->header.session, 5u);
    ASSERT_EQ(state.view().frame->session, 5u);
    ASSERT_EQ(state.view().frame->frame, number);
    ASSERT_EQ(state.view().poses->sim_time, 5);
    ASSERT_EQ(state.view().proxies[0]->sim_time, 5);
    ASSERT_EQ(state.view().status.at(kServerName).header.session, 5u);
  }
  EXPECT_NE(state.view().two_servers.find("shown is sim_server (process 5 on lab3), passed over is sim_server "
                                          "(process 6 on lab3)"),
            std::string::npos)
      << state.view().two_servers;
  EXPECT_EQ(state.view().refused, 0u);

  // the first one dies
  std::int64_t now = 2000 * kMs;
  for (int i = 0; i < 120; ++i, now += 10 * kMs) {
    state.add({chunks(6, 300 + static_cast<std::uint64_t>(i), 20).front(), now});
    state.forget(now);
  }
  EXPECT_EQ(state.view().scene->header.session, 6u);
  ASSERT_TRUE(state.view().frame);
  EXPECT_EQ(state.view().frame->session, 6u);
  EXPECT_FALSE(state.view().proxies[0]);
  EXPECT_NE(state.view().notice.find("has fallen silent; shown is sim_server (process 6 on lab3)"), std::string::npos)
      << state.view().notice;
  EXPECT_EQ(state.view().two_servers, "");
}

TEST(FeedState, AServerThatEndsGivesWayAtOnceAndItsLastWordStays) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  state.add(Received<Status>{server_status(5, "running", 5), 0});
  state.add(Received<Status>{server_status(5, "ended", 5), kMs});
  stay_silent(state, kMs, 10'000);
  ASSERT_TRUE(state.view().status.contains(kServerName));
  EXPECT_EQ(state.view().status.at(kServerName).state, "ended");
  state.add(Received<SceneDescription>{scene_of(6, 20), 10'002 * kMs});
  EXPECT_EQ(state.view().scene->header.session, 6u);
  state.add(Received<Status>{server_status(6, "running", 6), 10'003 * kMs});
  EXPECT_EQ(state.view().status.at(kServerName).state, "running");
}

TEST(FeedState, ARestartedServerWithAnotherSceneReplacesTheFirst) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  feed(state, chunks(5, 100, 10));
  ProxySample proxy;
  proxy.header.session = 5;
  state.add(Received<ProxySample>{proxy, 0});
  ASSERT_TRUE(state.view().proxies[0]);
  // it is no second server, for the first has been silent
  const std::int64_t later = stay_silent(state, 0, 1100);
  state.add(Received<SceneDescription>{scene_of(6, 20), later});
  EXPECT_FALSE(state.view().frame);
  EXPECT_FALSE(state.view().proxies[0]);
  state.add(Received<ProxySample>{proxy, later});  // a straggler of the first
  EXPECT_FALSE(state.view().proxies[0]);
  feed(state, chunks(6, 1, 20));
  ASSERT_TRUE(state.view().frame);
  EXPECT_EQ(state.view().frame->positions.size(), 60u);
}

TEST(FeedState, TheSameSceneSentAgainChangesNothing) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  feed(state, chunks(5, 1, 10));
  const auto scene = state.view().scene;
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  EXPECT_EQ(state.view().scene, scene);
  EXPECT_TRUE(state.view().frame);
}

TEST(FeedState, AFrameThatDoesNotFitItsSceneIsRefused) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  feed(state, chunks(5, 1, 11));
  EXPECT_FALSE(state.view().frame);
  EXPECT_EQ(state.view().refused, 1u);
}

TEST(FeedState, OldKnowledgeIsForgotten) {
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  ProxySample proxy;
  proxy.header.session = 5;
  state.add(Received<ProxySample>{proxy, 0});
  Status status;
  status.process = "sim_server";
  status.header.session = 5;
  state.add(Received<Status>{status, 0});
  CommandReply reply;
  reply.header.session = 5;
  reply.command_session = 1;
  reply.text = "no such parameter";
  state.add(Received<CommandReply>{reply, 0});
  state.forget(900 * kMs);
  EXPECT_TRUE(state.view().proxies[0]);
  state.forget(2000 * kMs);
  EXPECT_FALSE(state.view().proxies[0]);
  EXPECT_EQ(state.view().status.size(), 1u);
  EXPECT_EQ(state.view().notice, "no such parameter");
  state.forget(7000 * kMs);
  EXPECT_TRUE(state.view().status.empty());
  EXPECT_EQ(state.view().notice, "");
}

TEST(FeedState, ListsOfParametersAndRefusalsAreKeptApart) {
  FeedState state(true, 1);
  const auto answer = [&](std::uint64_t sequence, bool ok, const std::string& text, std::uint64_t to = 1) {
    CommandReply reply;
    reply.header.session = 5;
    reply.command_session = to;
    reply.command_sequence = sequence;
    reply.ok = ok;
    reply.text = text;
    state.add(Received<CommandReply>{reply, 0});
  };
  answer(3, false, "gravity is no number");
  EXPECT_EQ(state.view().refusal, "gravity is no number");
  EXPECT_EQ(state.view().answers, 1u);
  state.expect("", 4);
  answer(4, true, "somebody else's", 2);
  EXPECT_EQ(state.view().told_of(""), nullptr);
  answer(4, true, "a list");
  ASSERT_TRUE(state.view().told_of(""));
  EXPECT_EQ(*state.view().told_of(""), "a list");
  EXPECT_EQ(state.view().refusal, "gravity is no number") << "a list takes back nothing";
  EXPECT_EQ(state.view().notice, "gravity is no number");
  state.expect(kBillName, 6);
  answer(6, false, "there is no parameter 'bill'");
  EXPECT_EQ(state.view().told_of(kBillName), nullptr);
  EXPECT_EQ(state.view().notice, "gravity is no number") << "a server of before has no bill, which is no news";
  state.expect(kBillName, 7);
  answer(7, true, "a bill");
  ASSERT_TRUE(state.view().told_of(kBillName));
  EXPECT_EQ(*state.view().told_of(kBillName), "a bill");
  EXPECT_EQ(state.view().answers, 1u);
  answer(5, true, "gravity is 0 0 -5");
  EXPECT_EQ(state.view().refusal, "");
  EXPECT_EQ(state.view().answers, 2u);
}

// Spoils one of the things that a chunk says or holds.
void spoil(ParticleChunk& chunk, std::mt19937& random) {
  const auto any = [&random] { return static_cast<std::uint32_t>(random()); };
  switch (any() % 8) {
    case 0:
      chunk.chunk = any();
      break;
    case 1:
      chunk.chunk_count = any();
      break;
    case 2:
      chunk.particle_count = any();
      break;
    case 3:
      chunk.first = any();
      break;
    case 4:
      chunk.positions.resize(any() % 20000);
      break;
    case 5:
      chunk.scalars.resize(any() % 9000, std::nanf(""));
      break;
    case 6:
      chunk.field = static_cast<ScalarField>(any() % 9);
      break;
    default:
      chunk.positions.assign(chunk.positions.size(), std::nanf(""));
      break;
  }
}

// Returns a scene whose bodies say what cannot be.
SceneDescription scene_of_nonsense(std::mt19937& random) {
  const auto any = [&random] { return static_cast<std::uint32_t>(random()); };
  SceneDescription scene = scene_of(5 + any() % 2, 1 + any() % 9000);
  scene.bodies.resize(any() % 4);
  for (BodyDescription& body : scene.bodies) {
    body.kind = static_cast<BodyKind>(any() % 5);
    body.first = any();
    body.count = any();
    body.vertices.assign(any() % 40, 1e30f);
    body.triangles.assign(any() % 40, any() % 16);
  }
  return scene;
}

// Garbage of every kind between sound samples, through to the picture: nothing falls over, and the sound ones count.
TEST(FeedState, GarbageDoesNoHarm) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto any = [&random] { return static_cast<std::uint32_t>(random()); };
  Stage stage(small_stage(64, 48));
  int commands = 0;
  Session session(stage, ScalarField::speed, [&](CommandKind, const std::string&, const std::string&) { ++commands; });
  FeedState state(true, 1);
  for (int round = 0; round < 300; ++round) {
    std::vector<ParticleChunk> frame = chunks(5 + any() % 2, any() % 100, 1 + any() % 9000);
    spoil(frame[any() % frame.size()], random);
    feed(state, frame);
    const SceneDescription scene = scene_of_nonsense(random);
    if (round % 20 == 0) state.add(Received<SceneDescription>{scene, 0});
    BodyPoses poses;
    poses.header.session = 5 + any() % 2;
    poses.body.assign(any() % 5, any() % 5);
    poses.pose.resize(any() % 5);
    state.add(Received<BodyPoses>{poses, 0});
    ProxySample proxy;
    proxy.header.session = 5 + any() % 2;
    proxy.device = any() % 12;
    proxy.wrench.force[any() % 3] = any() % 2 ? std::nan("") : 1e300;
    state.add(Received<ProxySample>{proxy, 0});
    session.update(state.view(), round * 300 * kMs);
    if (round % 10 == 0) shoot(stage);
  }
  const auto next = scene_of(9, 10);
  state.add(Received<SceneDescription>{next, stay_silent(state, 0, 1100)});
  feed(state, chunks(9, 1, 10));
  ASSERT_TRUE(state.view().frame);
  session.update(state.view(), 1'000'000 * kMs);
  EXPECT_TRUE(session.figures().connected);
  EXPECT_GT(commands, 0);
}

TEST(Session, KeysSendTheirCommands) {
  Stage stage(small_stage(64, 48));
  std::vector<std::pair<CommandKind, std::string>> sent;
  Session session(stage, ScalarField::none, [&](CommandKind kind, const std::string&, const std::string& value) {
    sent.emplace_back(kind, value);
  });
  FeedState state(true, 1);
  state.add(Received<SceneDescription>{scene_of(5, 10), 0});
  session.update(state.view(), kMs);
  session.act({Action::pause_or_resume});
  ProxySample proxy;
  proxy.header.session = 5;
  proxy.flags = kPaused;
  state.add(Received<ProxySample>{proxy, 0});
  session.update(state.view(), 2 * kMs);
  for (const Action action : {Action::pause_or_resume, Action::single_step, Action::reset, Action::next_color}) {
    session.act({action});
  }
  const std::vector<std::pair<CommandKind, std::string>> expected{{CommandKind::pause, ""},
                                                                  {CommandKind::resume, ""},
                                                                  {CommandKind::step, ""},
                                                                  {CommandKind::reset, ""},
                                                                  {CommandKind::set_parameter, "speed"}};
  EXPECT_EQ(sent, expected);
}

}  // namespace
}  // namespace palp::test
