// The table of actions, from which keys, menu and help are made.
#include "viewer/controls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace palp::test {
namespace {

using Key = osgGA::GUIEventAdapter;

TEST(Controls, CapitalAndSmallLettersDiffer) {
  EXPECT_EQ(request_of('r'), Request{Action::home});
  EXPECT_EQ(request_of('R'), Request{Action::reset});
  EXPECT_EQ(request_of(' '), Request{Action::pause_or_resume});
  EXPECT_EQ(request_of(Key::KEY_F1), Request{Action::help});
  EXPECT_EQ(request_of(Key::KEY_Escape), Request{Action::let_go});
  EXPECT_FALSE(request_of('q'));
  EXPECT_FALSE(request_of(0));
}

TEST(Controls, EveryActionHasOneRowWithAKeyOfItsOwn) {
  std::set<Action> actions;
  std::set<int> keys;
  for (const ActionRow& row : action_rows()) {
    EXPECT_TRUE(actions.insert(row.action).second) << row.meaning;
    if (!takes_number(row.action)) {
      EXPECT_TRUE(keys.insert(row.key).second) << row.meaning;
      EXPECT_EQ(request_of(row.key), Request{row.action}) << row.meaning;
    }
    EXPECT_GT(std::string(row.meaning).size(), 0u);
  }
  EXPECT_EQ(actions.size(), static_cast<std::size_t>(Action::let_go) + 1) << "an action without a row";
}

TEST(Controls, MenusStandTogetherAndHelpHasEveryRow) {
  EXPECT_TRUE(std::ranges::is_sorted(action_rows(), {}, &ActionRow::menu));
  const auto lines = help_lines();
  for (const ActionRow& row : action_rows()) {
    const std::pair<std::string, std::string> line(row.key_name, row.meaning);
    EXPECT_EQ(std::ranges::count(lines, line), 1) << row.meaning;
  }
}

// On some keyboards shift with a digit is another letter, on others digits need shift.
TEST(Controls, DigitsRecallAndWithShiftStoreViews) {
  EXPECT_EQ(request_of('3'), (Request{Action::recall_view, 3}));
  EXPECT_EQ(request_of('#', '3', true), (Request{Action::store_view, 3}));
  EXPECT_EQ(request_of('3', '"', true), (Request{Action::store_view, 3}));
  EXPECT_FALSE(request_of('0'));
  EXPECT_FALSE(request_of('#', '3', false));
}

}  // namespace
}  // namespace palp::test
