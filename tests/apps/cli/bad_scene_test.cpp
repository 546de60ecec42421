// Tests the program with scenes with one error each: one line with the position and the expected
// value, exit status 1, and no file.

#include "cli.h"

namespace kinome::test::bad_scene_test {
namespace {

struct BadScene {
  const char* name;
  /// '@' marks the position that the error must name; it is removed. The contents of a <scene>, or
  /// the whole file if it contains "<scene" or "<?xml".
  const char* xml;
  std::vector<std::string> parts;  ///< of the message
  std::vector<std::string> options = {};
};

void PrintTo(const BadScene& scene, std::ostream* out) {
  *out << scene.name;
}

/// Returns `xml` without its mark, and the mark's LINE:COL.
std::pair<std::string, std::string> take_mark(std::string xml) {
  const size_t at = xml.find('@');
  if (at == std::string::npos) return {xml, ""};
  const auto line = 1 + std::count(xml.begin(), xml.begin() + static_cast<long>(at), '\n');
  const size_t line_start = at == 0 ? std::string::npos : xml.rfind('\n', at - 1);
  const size_t column = line_start == std::string::npos ? at + 1 : at - line_start;
  xml.erase(at, 1);
  return {xml, std::to_string(line) + ":" + std::to_string(column)};
}

class BadSceneTest : public Cli, public ::testing::WithParamInterface<BadScene> {};

TEST_P(BadSceneTest, ReportsOneErrorWithItsPosition) {
  std::string text = GetParam().xml;
  if (text.find("<scene") == std::string::npos && text.find("<?xml") == std::string::npos) {
    text = "<scene version=\"3.0.0\">\n" + text + "\n</scene>\n";
  }
  const auto [xml, place] = take_mark(text);
  const std::string scene = folder_.write("scene.xml", xml);
  std::vector<std::string> arguments = {scene};
  for (const std::string& option : GetParam().options) arguments.push_back(option);
  expect_one_error(kinome(arguments), scene + (place.empty() ? "" : ":" + place), GetParam().parts);
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{});
}

const BadScene kScenes[] = {
    // XML itself.
    {"unclosed_tag",
     "<scene version=\"3.0.0\">\n <shape type=\"sphere\">\n</@scene>",
     {"malformed XML"}},
    {"no_xml_at_all", "<?xml version=\"1.0\"?>\n@hello", {"malformed XML"}},
    // Names.
    {"unknown_tag", "@<shap type=\"sphere\"/>", {"<shap>", "'shape'"}},
    {"unknown_attribute", "<shape type=\"sphere\" @typo=\"1\"/>", {"typo"}},
    {"missing_type", "@<shape/>", {"type"}},
    {"unknown_plugin",
     "<shape type=\"sphere\">\n  <bsdf @type=\"difuse\"/></shape>",
     {"bsdf", "'difuse'", "'diffuse'"}},
    {"unknown_parameter",
     "<bsdf type=\"diffuse\" id=\"a\">\n  @<rgb name=\"reflectence\" value=\".5\"/></bsdf>",
     {"'reflectence'", "'reflectance'"}},
    {"object_where_none_belongs",
     "<bsdf type=\"diffuse\" id=\"a\">\n  @<sampler type=\"independent\"/></bsdf>",
     {"takes no sampler"}},
    // Types and values.
    {"wrong_type",
     "<shape type=\"sphere\">\n @<string name=\"radius\" value=\"1\"/></shape>",
     {"radius", "float", "string"}},
    {"float_for_integer",
     "<sensor type=\"perspective\"><film type=\"hdrfilm\">"
     "@<float name=\"width\" value=\"64\"/></film></sensor>",
     {"width", "integer"}},
    {"not_a_number",
     "<shape type=\"sphere\"><float name=\"radius\" @value=\"1m\"/></shape>",
     {"'1m'"}},
    {"not_an_integer",
     "<sensor type=\"perspective\"><sampler type=\"independent\">"
     "<integer name=\"sample_count\" @value=\"4.5\"/></sampler></sensor>",
     {"'4.5'"}},
    {"not_a_boolean",
     "<shape type=\"sphere\"><boolean name=\"flip_normals\" @value=\"1\"/></shape>",
     {"'1'"}},
    {"not_a_vector",
     "<shape type=\"sphere\"><point name=\"center\" @value=\"0 1\"/></shape>",
     {"'0 1'"}},
    {"out_of_range",
     "<shape type=\"sphere\">@<float name=\"radius\" value=\"-1\"/></shape>",
     {"radius", "positive", "-1"}},
    {"unknown_choice",
     "<sensor type=\"perspective\"><film type=\"hdrfilm\">"
     "@<string name=\"pixel_format\" value=\"rgbaa\"/></film></sensor>",
     {"rgbaa", "'rgba'"}},
    {"singular_transform",
     "<shape type=\"sphere\"><transform name=\"to_world\">@<scale value=\"1 0 1\"/></transform>"
     "</shape>",
     {"singular"}},
    {"bright_reflectance",
     "<bsdf type=\"diffuse\" id=\"a\">\n\n  @<rgb name=\"reflectance\" value=\".5 1.5 "
     ".5\"/></bsdf>",
     {"reflectance", "[0,1]", "1.5"}},
    {"negative_reflectance",
     "<bsdf type=\"diffuse\" id=\"a\">@<rgb name=\"reflectance\" value=\"-.1\"/></bsdf>",
     {"reflectance", "[0,1]"}},
    // Missing and repeated parameters.
    {"missing_parameter", "@<shape type=\"ply\"/>", {"ply", "filename"}},
    {"missing_aperture", "@<sensor type=\"thinlens\"/>", {"thinlens", "aperture_radius"}},
    {"parameter_given_twice",
     "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/>\n"
     "  @<float name=\"radius\" value=\"2\"/></shape>",
     {"'radius'", "twice", ":2:"}},
    {"id_given_twice",
     "<bsdf type=\"diffuse\" id=\"a\"/>\n<bsdf type=\"diffuse\" @id=\"a\"/>",
     {"'a'", "twice", ":2:"}},
    {"two_environments",
     "<emitter type=\"constant\"/>\n@<emitter type=\"constant\"/>",
     {"environment"}},
    // Misplaced emitters, and emitters without a shape.
    {"point_light_in_a_shape",
     "@<shape type=\"sphere\"><emitter type=\"point\"/></shape>",
     {"'area'", "move the emitter out of the shape"}},
    {"light_of_two_shapes",
     "<shape type=\"sphere\"><emitter type=\"area\" id=\"light\"/></shape>\n"
     "@<shape type=\"sphere\"><ref id=\"light\"/></shape>",
     {"one shape only"}},
    {"projector_without_an_angle",
     "<emitter type=\"projector\">@<float name=\"fov\" value=\"180\"/></emitter>",
     {"'fov'", "greater than 0 and less than 180", "got 180"}},
    {"projector_without_its_image",
     "<emitter type=\"projector\"><texture type=\"bitmap\" name=\"irradiance\">"
     "@<string name=\"filename\" value=\"slide.exr\"/></texture></emitter>",
     {"slide.exr", "can't be found"}},
    {"spot_without_an_angle",
     "<emitter type=\"spot\">@<float name=\"cutoff_angle\" value=\"0\"/></emitter>",
     {"'cutoff_angle'", "greater than 0"}},
    {"beam_wider_than_its_cone",
     "<emitter type=\"spot\">\n  @<float name=\"beam_width\" value=\"25\"/></emitter>",
     {"'beam_width'", "cutoff_angle (20", "got 25"}},
    {"negative_light",
     "<emitter type=\"point\">@<rgb name=\"intensity\" value=\"1 -1 1\"/></emitter>",
     {"'intensity'", "must be between 0 and 1e36"}},
    // $ and references.
    {"undefined_variable",
     "<shape type=\"sphere\"><float name=\"radius\" @value=\"$size\"/></shape>",
     {"'$size'"}},
    {"unused_define", "<emitter type=\"constant\"/>", {"-D color"}, {"-D", "color=1"}},
    {"dangling_reference", "<shape type=\"sphere\"><ref @id=\"gold\"/></shape>", {"'gold'"}},
    {"file_includes_itself", "<include @filename=\"scene.xml\"/>", {"includes itself"}},
    {"missing_include", "<include @filename=\"parts.xml\"/>", {"parts.xml"}},
    {"no_such_sensor",
     "<integrator type=\"path\"/><sensor type=\"perspective\" id=\"front\"/>",
     {"'frint'", "'front'"},
     {"-s", "frint"}},
    {"sensor_past_the_end",
     "<integrator type=\"path\"/><sensor type=\"perspective\"/>",
     {"unknown sensor '1'", "has only one, 0"},
     {"-s", "1"}},
};

INSTANTIATE_TEST_SUITE_P(All, BadSceneTest, ::testing::ValuesIn(kScenes),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(Cli, ErrorInAnIncludedFileNamesThatFile) {
  const std::string scene = folder_.write(
      "scene.xml", "<scene version=\"3.0.0\">\n<include filename=\"part.xml\"/></scene>");
  const std::string part =
      folder_.write("part.xml", "<scene version=\"3.0.0\">\n\n  <nonsense/></scene>");
  expect_one_error(kinome({scene}), part + ":3:3", {"<nonsense>"});
}

/// A render reports the first ten errors, --check all, with the same messages and in the same
/// order.
TEST_F(Cli, AllErrorsAreListed) {
  std::string shapes;
  for (int i = 0; i < 13; ++i) {
    shapes += "<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>\n";
  }
  const auto write = [&](const std::string& children) {
    return folder_.write("scene.xml", "<scene version=\"3.0.0\">\n" + children + "</scene>\n");
  };
  const std::string scene = write(shapes + "<emitter type=\"constnt\"/>\n");
  const auto line = [&](int i) {
    return scene + ":" + std::to_string(i + 2) +
           ":22: 'radius' must be positive and finite, got -1\n";
  };
  std::string first_ten, all;
  for (int i = 0; i < 13; ++i) {
    all += line(i);
    if (i < 10) first_ten += "kinome: " + line(i);
  }
  all += scene + ":15:10: unknown emitter plugin 'constnt' (did you mean 'constant'?)\n";
  const ProcessResult rendered = kinome({scene});
  EXPECT_EQ(rendered.status, 1);
  EXPECT_EQ(rendered.err, first_ten + "kinome: and 4 more: --check lists them all\n");
  EXPECT_EQ(rendered.out, "");
  const ProcessResult checked = kinome({"--check", scene});
  EXPECT_EQ(checked.status, 1);
  EXPECT_EQ(checked.out, all);
  EXPECT_EQ(checked.err, "");
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{});

  const ProcessResult good = kinome({write("<shape type=\"sphere\"/>\n"), "--check"});
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(good.out, "no faults\n");
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{});
  const ProcessResult more = kinome({scene, "--check", "-o", folder_.path("a.exr"), "-s", "1"});
  EXPECT_EQ(more.status, 0);
  EXPECT_NE(more.err.find("-o is ignored: --check renders nothing"), std::string::npos) << more.err;
  EXPECT_NE(more.err.find("-s is ignored: --check renders nothing"), std::string::npos) << more.err;
  EXPECT_EQ(more.out, "no faults\n");
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{});
  const ProcessResult missing = kinome({"--check", folder_.path("no.xml")});
  EXPECT_EQ(missing.status, 1);
  EXPECT_EQ(missing.out, folder_.path("no.xml") + ": no such file\n");
  const ProcessResult unused = kinome({"--check", scene, "-D", "spp=3"});
  EXPECT_EQ(unused.status, 1);
  EXPECT_EQ(unused.out, scene + ": the scene doesn't use -D spp (it uses none)\n");
}

TEST_F(Cli, SceneThatIsNotThere) {
  expect_one_error(kinome({folder_.path("nothing.xml")}), "", {folder_.path("nothing.xml")});
  expect_one_error(kinome({folder_.folder()}), "", {"folder"});
}

TEST_F(Cli, LibraryThatIsNoPlugin) {
  const std::string scene = folder_.write(
      "scene.xml", "<scene version=\"3.0.0\">\n  <integrator type=\"fake\"/></scene>");
  const std::string text = folder_.write("a/integrator/fake.so", "not a library at all");
  expect_one_error(kinome({scene, "--plugin-path", folder_.path("a")}), scene + ":2:15",
                   {text, "not a usable plugin"});
  // A valid library, but not a plugin.
  std::filesystem::create_directories(folder_.path("b/integrator"));
  std::filesystem::copy_file("/proc/self/exe", folder_.path("b/integrator/fake.so"));
  expect_one_error(kinome({scene, "--plugin-path", folder_.path("b")}), scene + ":2:15",
                   {"b/integrator/fake.so", "not a usable plugin"});
}

struct BadUsage {
  const char* name;
  std::vector<std::string> arguments;
  std::vector<std::string> parts;
};

void PrintTo(const BadUsage& usage, std::ostream* out) {
  *out << usage.name;
}

class BadUsageTest : public Cli, public ::testing::WithParamInterface<BadUsage> {};

TEST_P(BadUsageTest, IsOneError) {
  const std::string scene = folder_.write("scene.xml", small_scene());
  std::vector<std::string> arguments = GetParam().arguments;
  for (std::string& argument : arguments) {
    if (argument == "SCENE") argument = scene;
  }
  expect_one_error(kinome(arguments), "", GetParam().parts);
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{});
}

const BadUsage kUsages[] = {
    {"nothing", {}, {"scene.xml"}},
    {"unknown_option", {"SCENE", "--sats"}, {"unknown option '--sats'", "'--stats'"}},
    {"unknown_option_with_a_value", {"SCENE", "--sed=3"}, {"unknown option '--sed'", "'--seed'"}},
    {"unknown_option_alone", {"--foo"}, {"unknown option '--foo'"}},
    {"unknown_short_option", {"-x", "SCENE"}, {"unknown option '-x'"}},
    {"unknown_option_of_plugins",
     {"plugins", "diffuse", "--markdwn"},
     {"unknown option '--markdwn'", "'--markdown'", "kinome plugins --help"}},
    {"two_scenes", {"SCENE", "SCENE"}, {"not expected", "one scene"}},
    {"samples", {"SCENE", "--spp", "4"}, {"unknown option '--spp'", "'-D spp=4'"}},
    {"samples_by_equals", {"SCENE", "--spp=4"}, {"unknown option '--spp'", "'-D spp=4'"}},
    {"samples_without_a_number", {"--spp", "SCENE"}, {"unknown option '--spp'", "'-D spp=VALUE'"}},
    {"samples_by_one_dash", {"-spp", "4", "SCENE"}, {"unknown option '-spp'", "'-D spp=4'"}},
    {"option_of_one_dash", {"-time", "4", "SCENE"}, {"unknown option '-time'", "'--time'"}},
    {"option_of_mitsuba", {"-V", "8", "SCENE"}, {"unknown option '-V'; leave it out", "LLVM"}},
    {"option_of_old_mitsuba", {"-p", "8", "SCENE"}, {"unknown option '-p'; -t COUNT"}},
    {"define_with_a_space", {"-Dspp", "8", "SCENE"}, {"-D: expected KEY=VALUE", "'-D spp=8'"}},
    {"command_with_a_mistake", {"plugin"}, {"unknown command 'plugin'", "'plugins'"}},
    {"command_with_a_mistake_and_a_word",
     {"plugn", "SCENE"},
     {"unknown command 'plugn'", "'plugins'"}},
    {"command_after_an_option", {"-q", "merge"}, {"the command 'merge' must come first"}},
    {"command_after_an_option_with_arguments",
     {"-q", "merge", "a.exr", "-o", "b.exr"},
     {"the command 'merge' must come first"}},
    {"command_for_help", {"help"}, {"unknown command 'help'", "'--help'"}},
    {"command_of_another_program", {"render", "SCENE"}, {"kinome SCENE.xml renders"}},
    {"no_scene_of_that_name", {"nothing"}, {"unknown command 'nothing', and no file of this name"}},
    {"variance_by_space", {"--variance", "4", "SCENE"}, {"after '=': --variance=4"}},
    {"time_not_a_number",
     {"SCENE", "--time", "abc"},
     {"--time: must be a number of seconds, got 'abc'"}},
    {"exposure_not_a_number", {"SCENE", "--exposure", "a"}, {"must be a number of stops, got 'a'"}},
    {"threads_not_a_number",
     {"SCENE", "-t", "many"},
     {"--threads: must be a whole number between 1 and 1024, got 'many'"}},
    {"sensor_beyond_the_last",
     {"SCENE", "-s", "2"},
     {"unknown sensor '2': the scene has 2, 0 to 1 ('front', 'above')"}},
    {"no_threads", {"SCENE", "-t", "0"}, {"--threads", "0"}},
    {"negative_seed",
     {"SCENE", "--seed", "-1"},
     {"--seed: must be a whole number between 0 and 18446744073709551615, got '-1'\n"}},
    {"seed_with_a_fraction", {"SCENE", "--seed", "1.5"}, {"--seed: must be", "got '1.5'\n"}},
    {"seed_that_is_empty", {"SCENE", "--seed", ""}, {"--seed"}},
    {"seed_beyond_all",
     {"SCENE", "--seed", "18446744073709551616"},
     {"--seed: must be", "got '18446744073709551616'\n"}},
    {"define_without_value", {"SCENE", "-D", "spp"}, {"-D", "KEY=VALUE", "spp"}},
    {"define_twice", {"SCENE", "-D", "spp=1", "-D", "spp=2"}, {"'spp'", "twice"}},
    {"option_without_value", {"SCENE", "-o"}, {"--output needs a value: FILE"}},
    {"no_name_for_the_picture", {"SCENE", "-o", ""}, {"--output", "empty"}},
    {"exposure_that_is_empty", {"SCENE", "--exposure", ""}, {"--exposure", "empty"}},
    {"pixel_that_is_empty", {"SCENE", "--inspect", ""}, {"--inspect", "empty"}},
    {"interval_that_is_empty", {"SCENE", "--every", ""}, {"--every", "empty"}},
    {"stats_of_another_kind", {"SCENE", "--stats=xml"}, {"--stats", "xml", "json"}},
    {"verbose_with_a_value",
     {"SCENE", "--verbose=34343434343434343434"},
     {"--verbose", "takes no value"}},
    {"png_with_a_value", {"SCENE", "--png=no"}, {"--png", "takes no value"}},
    {"variance_of_too_many", {"SCENE", "--variance=34343434343434343434"}, {"--variance"}},
    {"picture_of_an_unknown_format",
     {"SCENE", "-o", "picture.jpgg"},
     {"picture.jpgg", "unknown image format '.jpgg': use .exr, .pfm", ".jpg"}},
    {"crop_of_three_numbers", {"SCENE", "--crop", "1,2,3"}, {"--crop", "X,Y,W,H", "'1,2,3'"}},
    {"crop_without_pixels", {"SCENE", "--crop", "1,2,0,3"}, {"--crop", "X,Y,W,H"}},
    {"crop_before_the_film", {"SCENE", "--crop=-1,2,4,3"}, {"--crop", "X,Y,W,H"}},
    {"crop_beyond_the_film",
     {"SCENE", "--crop", "40,0,9,48"},
     {"--crop 40,0,9,48", "48x48", "column 49"}},
    {"unknown_plugin_to_list", {"plugins", "difuse"}, {"'difuse'", "'diffuse'"}},
};

INSTANTIATE_TEST_SUITE_P(All, BadUsageTest, ::testing::ValuesIn(kUsages),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace kinome::test::bad_scene_test
