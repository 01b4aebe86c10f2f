// SPDX-License-Identifier: MIT
// Every described field (kibori/base/field_info.h) has the same value after it was written to a
// document or a scene and read again.
#include <array>
#include <utility>

#include <gtest/gtest.h>

#include <cstdio>

#include <kibori/document/json_fields.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/reshape/brush.h>
#include <kibori/scene/scene.h>

namespace kibori::fields_tests {
namespace {

// A different valid value for a field.
template <class Value>
void change(Value& value);
template <Described T>
T changed() {
  T all;
  T::for_fields([&](const FieldInfo&, auto member) { change(all.*member); });
  return all;
}
template <class Value>
void change(Value& value) {
  if constexpr (Described<Value>)
    value = changed<Value>();
  else if constexpr (Named<Value>)
    value = static_cast<Value>((static_cast<size_t>(value) + 1) % names_of(value).size());
  else if constexpr (std::is_same_v<Value, bool>)
    value = !value;
  else if constexpr (std::is_same_v<Value, std::string>)
    value += " b";
  else if constexpr (std::is_same_v<Value, double>)
    value += 0.25;
  else if constexpr (std::is_same_v<Value, Vec3>)
    value += Vec3(0.25, 0.5, 1.0 / 3);
  else
    value = {1, 20, 255};
}

template <Described T>
void expect_same(const T& a, const T& b, bool all) {
  T::for_fields([&](const FieldInfo& field, auto member) {
    if (all || field.stored != Stored::where_used) {
      EXPECT_TRUE(a.*member == b.*member) << field.key;
    }
  });
}

template <class T>
class DescribedFields : public testing::Test {};
using Types = testing::Types<Brush, FlatPlane, Material, SeriesSpring>;
TYPED_TEST_SUITE(DescribedFields, Types);

TYPED_TEST(DescribedFields, RoundTripThroughJson) {
  const TypeParam one = changed<TypeParam>();
  const Json json = fields_to_json(one);
  TypeParam back;
  const Status read = fields_from_json(json, "it", back);
  ASSERT_TRUE(read.ok()) << read.error();
  expect_same(one, back, false);
  // A missing key, or an invalid value.
  TypeParam::for_fields([&](const FieldInfo& field, auto) {
    if (field.stored == Stored::where_used) return;
    Json without = json;
    without.erase(field.key);
    const Status missing = fields_from_json(without, "it", back);
    EXPECT_EQ(missing.ok(), field.stored != Stored::required) << field.key;
    Json wrong = json;
    wrong[field.key] = Json::object();
    // A colour that cannot be read stays; a log may leave out everything.
    const bool tolerant =
        field.key == std::string_view("color") || field.key == std::string_view("log");
    EXPECT_EQ(fields_from_json(wrong, "it", back).ok(), tolerant) << field.key;
  });
}

template <Described T>
std::string keys(const T& of, const std::string& between);

template <class Value>
std::string toml(const Value& value) {
  char text[64];
  if constexpr (std::is_same_v<Value, double>) {
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_same_v<Value, std::string>) {
    return '"' + value + '"';
  } else if constexpr (Named<Value>) {
    return '"' + std::string(name_of(value)) + '"';
  } else if constexpr (std::is_same_v<Value, std::array<double, 3>>) {
    return "[" + toml(value[0]) + ", " + toml(value[1]) + ", " + toml(value[2]) + "]";
  } else if constexpr (std::is_same_v<Value, Vec3>) {
    return "[" + toml(value.x()) + ", " + toml(value.y()) + ", " + toml(value.z()) + "]";
  } else if constexpr (Described<Value>) {
    return "{ " + keys(value, ", ") + " }";
  } else {
    std::snprintf(text, sizeof text, "\"#%02x%02x%02x\"", value[0], value[1], value[2]);
    return text;
  }
}
template <Described T>
std::string keys(const T& of, const std::string& between) {
  std::string text;
  T::for_fields([&](const FieldInfo& field, auto member) {
    if (std::string_view(field.name) == "flatten_to") return;  // the key `plane` implies it
    if (std::is_same_v<T, Material>) {
      const std::string_view name = field.name;
      if (name == "u" || name == "log") return;  // `k` excludes u; the log belongs to the stock
    }
    if (!text.empty()) text += between;
    text.append(field.name).append(" = ").append(toml(of.*member));
  });
  return text;
}

TEST(SceneFields, RoundTripThroughAScene) {
  Material material = changed<Material>();
  const LogCut log = std::exchange(material.log, {});  // in a scene it belongs to the stock
  const SeriesSpring spring = changed<SeriesSpring>();
  Brush brush = changed<Brush>();
  brush.flatten_to = FlattenTo::plane;
  brush.mask_material = 5;  // a whole number
  const Result<Scene> scene =
      parse_scene("[force]\nmodel = \"series\"\n" + keys(spring, "\n") + "\n[[material]]\n" +
                      keys(material, "\n") +
                      "\n[stock]\nblock = [20, 20, 20]\npitch = 1\nlog = { " + keys(log, ", ") +
                      " }\n[tool]\nshape = \"ball\"\nradius = 2\n"
                      "[[move]]\nto = [10, 10, 30]\n[[move]]\nto = [10, 10, 20]\nspeed = 10\n"
                      "mode = \"flatten\"\nbrush = { " +
                      keys(brush, ", ") + " }\n",
                  "fields.toml", std::nullopt);
  ASSERT_TRUE(scene.ok()) << scene.error();
  material.log = log;
  material.u = mean_cutting_energy(material);
  expect_same(scene.value().materials.front(), material, true);
  expect_same(scene.value().force.spring, spring, true);
  expect_same(scene.value().moves.back().brush, brush, true);
}

}  // namespace
}  // namespace kibori::fields_tests
