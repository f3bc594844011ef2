#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <optional>
#include <sstream>

#include "config/error.h"
#include "config/text_file.h"
#include "sim_server/geometry/mesh.h"

namespace palp {

namespace {

static_assert(std::endian::native == std::endian::little,
              "binary STL and PLY are read as the processor stores numbers");

constexpr std::uint64_t kMostItems = std::uint64_t{1} << 28;  // vertices, triangles or corners, against absurd counts

// Lines of a text, with their numbers, split at blanks.
class Lines {
 public:
  Lines(std::string_view text, std::string path) : text_(text), path_(std::move(path)) {}
  bool next() {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line_ = text_.substr(at_, end - at_);
    at_ = end + 1;
    ++number_;
    words_.clear();
    for (std::size_t i = 0; i < line_.size();) {
      const std::size_t first = line_.find_first_not_of(" \t\r\f\v", i);
      if (first == std::string_view::npos) break;
      i = std::min(line_.find_first_of(" \t\r\f\v", first), line_.size());
      words_.push_back(line_.substr(first, i - first));
    }
    return true;
  }
  // The next line that has words and is no comment.
  bool next_filled() {
    while (next()) {
      if (!words_.empty() && words_[0][0] != '#') return true;
    }
    return false;
  }
  const std::vector<std::string_view>& words() const { return words_; }
  std::size_t at() const { return std::min(at_, text_.size()); }
  [[noreturn]] void fail(const std::string& what) const {
    throw ConfigError(fmt::format("{}:{}: {}", path_, number_, what));
  }
  double number(std::size_t word) const {
    if (word >= words_.size())
      fail(fmt::format("the line has {} words, expected at least {}", words_.size(), word + 1));
    const auto value = parse_number(words_[word]);
    if (!value) fail(fmt::format("'{}' is not a finite number", words_[word].substr(0, 40)));
    return *value;
  }
  Eigen::Vector3d point(std::size_t word) const { return {number(word), number(word + 1), number(word + 2)}; }

 private:
  std::string_view text_;
  std::string path_;
  std::string_view line_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0, number_ = 0;
};

// A polygon as a fan of triangles.
void add_polygon(SurfaceMesh& mesh, const std::vector<std::uint32_t>& corners) {
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

SurfaceMesh read_obj(std::string_view text, const std::string& path) {
  SurfaceMesh mesh;
  Lines lines(text, path);
  std::vector<std::uint32_t> corners;
  while (lines.next_filled()) {
    const auto& words = lines.words();
    if (words[0] == "v") mesh.vertices.push_back(lines.point(1));
    if (words[0] != "f") continue;
    if (words.size() < 4) lines.fail("a face has fewer than three corners");
    corners.clear();
    for (std::size_t w = 1; w < words.size(); ++w) {
      const auto index = parse_number(words[w].substr(0, words[w].find('/')));
      const double count = static_cast<double>(mesh.vertices.size());
      const double number = index.value_or(0) < 0 ? count + *index + 1 : index.value_or(0);
      if (!(number >= 1 && number <= count) || number != static_cast<double>(static_cast<std::uint32_t>(number))) {
        lines.fail(fmt::format("a face names vertex '{}', expected a whole number from 1 to {}", words[w].substr(0, 40),
                               mesh.vertices.size()));
      }
      corners.push_back(static_cast<std::uint32_t>(number) - 1);
    }
    add_polygon(mesh, corners);
  }
  return mesh;
}

template <class Value>
Value take(std::string_view bytes, std::size_t at) {
  Value value;
  std::memcpy(&value, bytes.data() + at, sizeof(Value));
  return value;
}

SurfaceMesh read_binary_stl(std::string_view bytes, const std::string& path) {
  const auto count = take<std::uint32_t>(bytes, 80);
  if (bytes.size() != 84 + std::uint64_t{count} * 50) {
    throw ConfigError(
        fmt::format("{}: a binary STL of {} triangles has {} bytes, but the file has {}; it is cut off or not "
                    "an STL",
                    path, count, 84 + std::uint64_t{count} * 50, bytes.size()));
  }
  SurfaceMesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    const std::uint32_t base = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t v = 0; v < 3; ++v) {
      const std::size_t at = 84 + std::size_t{t} * 50 + 12 + v * 12;
      mesh.vertices.emplace_back(take<float>(bytes, at), take<float>(bytes, at + 4), take<float>(bytes, at + 8));
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
  return mesh;
}

SurfaceMesh read_text_stl(std::string_view text, const std::string& path) {
  SurfaceMesh mesh;
  Lines lines(text, path);
  std::size_t in_loop = 0;
  bool closed = false;
  while (lines.next_filled()) {
    const auto& words = lines.words();
    if (words[0] == "vertex") {
      if (++in_loop > 3) lines.fail("a facet has more than three vertices");
      mesh.vertices.push_back(lines.point(1));
    } else if (words[0] == "endloop") {
      if (in_loop != 3) lines.fail(fmt::format("a facet has {} vertices, expected 3", in_loop));
      in_loop = 0;
      const auto end = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.triangles.push_back({end - 3, end - 2, end - 1});
    } else if (words[0] == "endsolid") {
      closed = true;
    } else if (words[0] != "solid" && words[0] != "facet" && words[0] != "outer" && words[0] != "endfacet") {
      lines.fail(fmt::format("'{}' has no meaning in an STL file", words[0].substr(0, 40)));
    }
  }
  if (in_loop != 0 || !closed) throw ConfigError(path + ": the STL file ends in the middle; it is cut off");
  return mesh;
}

// Some programs begin binary files with "solid", too. Text has no control characters but blanks and ends of lines, and
// the numbers of a binary file have some soon: the count of its triangles does unless there are millions of them.
bool is_text_stl(std::string_view bytes) {
  if (bytes.size() >= 84 && bytes.size() == 84 + std::uint64_t{take<std::uint32_t>(bytes, 80)} * 50) return false;
  const std::string_view beginning = bytes.substr(0, 1000);
  return bytes.substr(0, 5) == "solid" && std::none_of(beginning.begin(), beginning.end(), [](char c) {
           return static_cast<unsigned char>(c) < 0x20 && !std::isspace(static_cast<unsigned char>(c));
         });
}

SurfaceMesh read_stl(std::string_view bytes, const std::string& path) {
  if (is_text_stl(bytes)) return read_text_stl(bytes, path);
  if (bytes.size() < 84) throw ConfigError(fmt::format("{}: {} bytes are too few for an STL file", path, bytes.size()));
  return read_binary_stl(bytes, path);
}

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> count_type;  // of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

PlyType ply_type(const Lines& lines, std::string_view word) {
  static constexpr std::pair<std::string_view, PlyType> kNames[] = {
      {"char", PlyType::i8},   {"int8", PlyType::i8},     {"uchar", PlyType::u8},   {"uint8", PlyType::u8},
      {"short", PlyType::i16}, {"int16", PlyType::i16},   {"ushort", PlyType::u16}, {"uint16", PlyType::u16},
      {"int", PlyType::i32},   {"int32", PlyType::i32},   {"uint", PlyType::u32},   {"uint32", PlyType::u32},
      {"float", PlyType::f32}, {"float32", PlyType::f32}, {"double", PlyType::f64}, {"float64", PlyType::f64}};
  for (const auto& [name, type] : kNames) {
    if (name == word) return type;
  }
  lines.fail(fmt::format("'{}' is not a PLY number type", word.substr(0, 40)));
}

// Numbers of the body, one after another, from text or bytes.
class PlyNumbers {
 public:
  PlyNumbers(std::string_view body, bool binary, const std::string& path) : body_(body), binary_(binary), path_(path) {}

  double next(PlyType type) {
    if (!binary_) return next_word();
    switch (type) {
      case PlyType::i8:
        return raw<std::int8_t>();
      case PlyType::u8:
        return raw<std::uint8_t>();
      case PlyType::i16:
        return raw<std::int16_t>();
      case PlyType::u16:
        return raw<std::uint16_t>();
      case PlyType::i32:
        return raw<std::int32_t>();
      case PlyType::u32:
        return raw<std::uint32_t>();
      case PlyType::f32:
        return static_cast<double>(raw<float>());
      case PlyType::f64:
        return raw<double>();
    }
    return 0;
  }

 private:
  [[noreturn]] void cut_off() const { throw ConfigError(path_ + ": the PLY file ends in the middle; it is cut off"); }

  template <class Value>
  Value raw() {
    if (body_.size() - at_ < sizeof(Value)) cut_off();
    const Value value = take<Value>(body_, at_);
    at_ += sizeof(Value);
    return value;
  }

  double next_word() {
    const std::size_t first = body_.find_first_not_of(" \t\r\n", at_);
    if (first == std::string_view::npos) cut_off();
    at_ = std::min(body_.find_first_of(" \t\r\n", first), body_.size());
    const std::string_view word = body_.substr(first, at_ - first);
    const auto value = parse_number(word);
    if (!value) throw ConfigError(fmt::format("{}: '{}' is not a finite number", path_, word.substr(0, 40)));
    return *value;
  }

  std::string_view body_;
  bool binary_;
  std::string path_;
  std::size_t at_ = 0;
};

// Reads the header; `lines` stands after it.
std::vector<PlyElement> read_ply_header(Lines& lines, bool& binary) {
  std::vector<PlyElement> elements;
  bool format = false;
  if (!lines.next() || lines.words().empty() || lines.words()[0] != "ply") lines.fail("expected the word 'ply'");
  while (lines.next()) {
    const auto& words = lines.words();
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") {
      if (!format) lines.fail("the header names no format");
      return elements;
    }
    if (words[0] == "format" && words.size() == 3 && (words[1] == "ascii" || words[1] == "binary_little_endian")) {
      binary = words[1] != "ascii";
      format = true;
    } else if (words[0] == "format") {
      lines.fail("the format is not known, expected ascii or binary_little_endian");
    } else if (words[0] == "element" && words.size() == 3) {
      const double count = lines.number(2);
      if (!(count >= 0 && count <= static_cast<double>(kMostItems)))
        lines.fail("the count of elements is out of range");
      elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(count), {}});
    } else if (words[0] == "property" && !elements.empty() && words.size() == 3) {
      elements.back().properties.push_back({std::string(words[2]), ply_type(lines, words[1]), {}});
    } else if (words[0] == "property" && !elements.empty() && words.size() == 5 && words[1] == "list") {
      elements.back().properties.push_back(
          {std::string(words[4]), ply_type(lines, words[3]), ply_type(lines, words[2])});
    } else {
      lines.fail(fmt::format("'{}' is not understood in a PLY header", words[0].substr(0, 40)));
    }
  }
  lines.fail("the header has no end_header");
}

// One list of a face, or of anything else when `corners` is null.
void read_ply_list(PlyNumbers& numbers, const PlyProperty& property, std::vector<double>* corners,
                   const std::string& path) {
  const double count = numbers.next(*property.count_type);
  if (!(count >= 0 && count <= 1e6))
    throw ConfigError(fmt::format("{}: a list has {} items, expected 0 to 1e6", path, count));
  for (double i = 0; i < count; ++i) {
    const double value = numbers.next(property.type);
    if (corners) corners->push_back(value);
  }
}

SurfaceMesh read_ply(std::string_view bytes, const std::string& path) {
  Lines lines(bytes, path);
  bool binary = false;
  const std::vector<PlyElement> elements = read_ply_header(lines, binary);
  PlyNumbers numbers(bytes.substr(lines.at()), binary, path);
  SurfaceMesh mesh;
  std::vector<double> corners;
  std::vector<std::uint32_t> indices;
  for (const PlyElement& element : elements) {
    if (element.properties.empty() && element.count > 0) throw ConfigError(path + ": a PLY element has no property");
    for (std::uint64_t n = 0; n < element.count; ++n) {
      Eigen::Vector3d point = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      corners.clear();
      for (const PlyProperty& property : element.properties) {
        if (property.count_type) {
          const bool wanted =
              element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
          read_ply_list(numbers, property, wanted ? &corners : nullptr, path);
          continue;
        }
        const double value = numbers.next(property.type);
        if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
          point[property.name[0] - 'x'] = value;
      }
      if (element.name == "vertex") mesh.vertices.push_back(point);
      indices.clear();
      for (const double corner : corners) {
        if (!(corner >= 0 && corner < static_cast<double>(mesh.vertices.size()) && corner == std::floor(corner))) {
          throw ConfigError(fmt::format("{}: face {} names vertex {}, expected 0 to {} (vertices before faces)", path,
                                        n + 1, corner, mesh.vertices.size()));
        }
        indices.push_back(static_cast<std::uint32_t>(corner));
      }
      add_polygon(mesh, indices);
    }
  }
  return mesh;
}

}  // namespace

SurfaceMesh read_mesh(const std::string& bytes, const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (bytes.empty()) throw ConfigError(path + ": the file is empty");
  if (ending == ".obj") return read_obj(bytes, path);
  if (ending == ".stl") return read_stl(bytes, path);
  if (ending == ".ply") return read_ply(bytes, path);
  throw ConfigError(fmt::format("{}: the ending '{}' is not known, expected .obj, .stl or .ply", path, ending));
}

}  // namespace palp
