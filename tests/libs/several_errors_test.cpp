// Tests scenes with several errors.

#include <gtest/gtest.h>

#include "support/plugins/probe_registry.h"

namespace kinome::test::several_errors_test {
namespace {

/// A scene with several errors. Each marked position is reported once, in order. Errors that only
/// follow from others are not reported.
struct Several {
  const char* name;
  const char* xml;  ///< children of <scene>
  std::vector<std::string> messages;
  std::map<std::string, std::string> defines = {};
};

const Several kSeveral[] = {
    {"OfEachPhase",
     "^<spehre/>\n"
     "<shape type='sphere' ^nmae='x'/>\n"
     "<bsdf type='diffuse' ^id='$x'/>\n"
     "<shape type='sphere'><float name='radius' ^value='1m'/></shape>\n"
     "<bsdf type='diffuse' id='red'>^<rgb name='reflectence' value='.5'/></bsdf>\n"
     "<shape type='sphere'>^<float name='radius' value='-1'/></shape>\n"
     "<shape type='ply'>^<string name='filename' value='box.ply'/></shape>",
     {"unknown tag", "<shape> has no attribute 'nmae'", "undefined parameter '$x'",
      "'1m' is not a number", "bsdf 'diffuse' has no parameter 'reflectence'",
      "'radius' must be positive", "'filename' can't be found: there is no file 'box.ply'"}},
    {"RefsBesideOthers",
     "<shape type='sphere'><ref ^id='rad'/></shape>\n<bsdf type='diffuse' id='red'/>^<float "
     "value='1'/>",
     {"unknown id 'rad' (did you mean 'red'?)", "<float> needs an attribute 'name'"}},
    // An invalid object is not reported as missing by its parent.
    {"BsdfOfAWrongType",
     "<bsdf type='twosided' id='a'><bsdf ^type='difuse'/></bsdf>",
     {"unknown bsdf plugin 'difuse'"}},
    {"UnknownTagInPlaceOfABsdf",
     "<bsdf type='twosided' id='a'>^<bsfd type='diffuse'/></bsdf>",
     {"unknown tag <bsfd> (did you mean 'bsdf'?)"}},
    {"BsdfWithAMistakeInIt",
     "<shape type='sphere'><bsdf type='twosided'><bsdf type='diffuse'>"
     "^<rgb name='reflectance' value='2'/></bsdf></bsdf></shape>",
     {"'reflectance' is outside [0,1]"}},
    {"WrongNameOfWhatIsNeeded",
     "<shape type='ply'>^<string name='filname' value='a.ply'/></shape>",
     {"shape 'ply' has no parameter 'filname' (did you mean 'filename'?)"}},
    {"WrongAttributeOfWhatIsNeeded",
     "<shape type='ply'><string name='filename' ^vlaue='a.ply'/></shape>",
     {"<string> has no attribute 'vlaue' (did you mean 'value'?)"}},
    {"SubstitutionInWhatIsNeeded",
     "<shape type='ply'><string name='filename' ^value='$mesh'/></shape>",
     {"undefined parameter '$mesh'"}},
    {"SensorWithoutItsFilm",
     "<sensor type='perspective'><film ^type='hdrflim'/></sensor>",
     {"unknown film plugin 'hdrflim'"}},
    {"IntegratorThatFails",
     "<integrator type='direct'>^<float name='x' value='1'/></integrator>",
     {"integrator 'direct' has no parameter 'x'"}},
    // References to invalid objects, or to objects that may be inside invalid ones.
    {"RefToWhatHasAMistake",
     "<bsdf ^typ='diffuse' id='a'/><shape type='sphere'><ref id='a'/></shape>",
     {"<bsdf> has no attribute 'typ'"}},
    {"RefsToWhatHasAMistakeInside",
     "<bsdf type='diffuse' id='a'>^<float name='x' value='1'/></bsdf>"
     "<shape type='sphere'><ref id='a'/></shape><shape type='sphere'><ref id='a'/></shape>",
     {"bsdf 'diffuse' has no parameter 'x'"}},
    {"RefToAnUnknownTag",
     "^<bsfd type='diffuse' id='a'/><shape type='sphere'><ref id='a'/></shape>",
     {"unknown tag <bsfd>"}},
    {"RefToAnIdThatIsNone",
     "<bsdf type='diffuse' ^id='a$x'/><shape type='sphere'><ref id='a1'/></shape>",
     {"undefined parameter '$x'"}},
    {"RefIntoALostInclude",
     "<include ^filename='no.xml'/><shape type='sphere'><ref id='a'/></shape>",
     {"there is no file 'no.xml'"}},
    {"RefToALostAlias",
     "<alias ^id='a' as='b'/><shape type='sphere'><ref id='b'/></shape>",
     {"no earlier object has the id 'a'"}},
    // Names whose definitions may be lost.
    {"DefaultOfALostInclude",
     "<include ^filename='no.xml'/><shape type='sphere'><float name='radius' value='$r'/></shape>",
     {"there is no file 'no.xml'"},
     {{"define", "1"}}},
    {"LostDefault",
     "<default name='a' ^value='$b'/><shape type='sphere'><float name='radius' "
     "value='$a'/></shape>",
     {"undefined parameter '$b'"}},
    {"DefineAndItsMisspelling",
     "<bsdf type='diffuse' ^id='$sampels'/>",
     {"undefined parameter '$sampels' (did you mean '$samples'?)"},
     {{"samples", "1"}}},
    {"LostPath",
     "<path ^value='maps'/><shape type='ply'><string name='filename' value='a.ply'/></shape>",
     {"no such folder: 'maps'"}},
    {"UnknownTagInPlaceOfADefault",
     "^<defualt name='r' value='2'/><shape type='sphere'><float name='radius' value='$r'/></shape>",
     {"unknown tag <defualt> (did you mean 'default'?)"}},
    {"UnknownTagInPlaceOfAnAlias",
     "<bsdf type='diffuse' id='a'/>^<alais id='a' as='b'/><shape type='sphere'><ref "
     "id='b'/></shape>",
     {"unknown tag <alais> (did you mean 'alias'?)"}},
    {"UnknownTagInPlaceOfAnInclude",
     "^<inclyde filename='a.xml'/><shape type='sphere'><float name='radius' value='$r'/>"
     "<ref id='b'/></shape>",
     {"unknown tag <inclyde> (did you mean 'include'?)"}},
    {"MisspeltId",
     "<bsdf type='diffuse' ^idd='a'/><shape type='sphere'><ref id='a'/></shape>",
     {"<bsdf> has no attribute 'idd' (did you mean 'id'?)"}},
    {"EmptyIdThatIsNone",
     "<bsdf type='diffuse' id=''/><shape type='sphere'><ref ^id='a'/></shape>",
     {"unknown id 'a'"}},
    {"MisspeltAlias",
     "<bsdf type='diffuse' id='a'/><alias id='a' ^ass='b'/><shape type='sphere'><ref "
     "id='b'/></shape>",
     {"<alias> has no attribute 'ass' (did you mean 'as'?)"}},
    {"UnknownNameOfWhatIsNeeded",
     "<shape type='ply'>^<string name='mesh' value='a.ply'/></shape>",
     {"shape 'ply' has no parameter 'mesh'"}},
    {"NoNameOfATextureThatIsNeeded",
     "<bsdf type='normalmap'>^<texture type='checkerboard'/><bsdf type='diffuse'/></bsdf>",
     {"a texture of bsdf 'normalmap' needs a name"}},
    {"SecondTextureOfAnyName",
     "<bsdf type='bumpmap'><texture type='checkerboard' name='a'/>"
     "^<texture type='checkerboard' name='b'/><bsdf type='diffuse'/></bsdf>",
     {"bsdf 'bumpmap' takes at most 1 texture (the first is at scene.xml:1:45)"}},
    {"ReservedNameOfATextureThatIsNeeded",
     "<bsdf type='normalmap'><texture type='checkerboard' ^name='_arg_0'/><bsdf "
     "type='diffuse'/></bsdf>",
     {"'_arg_0': names that begin with _arg_ or _default_ are reserved"}},
    {"ReservedNameOfAValueThatIsNeeded",
     "<bsdf type='blendbsdf'><float ^name='_arg_0' value='1'/><bsdf type='diffuse'/>"
     "<bsdf type='diffuse'/></bsdf>",
     {"'_arg_0': names that begin with _arg_ or _default_ are reserved"}},
    {"WrongNameOfATextureThatIsNeeded",
     "<bsdf type='normalmap'><texture type='checkerboard' ^nmae='normalmap'/><bsdf "
     "type='diffuse'/></bsdf>",
     {"<texture> has no attribute 'nmae'"}},
    {"UnknownNameByDollar",
     "<shape type='ply'><string ^name='$zz' value='a.ply'/></shape>",
     {"undefined parameter '$zz'"}},
    // Several errors in one object.
    {"ParametersOfOneObject",
     "^<sensor type='thinlens'><float name='fov' ^value='x'/>^<float name='fvo' value='1'/>"
     "<transform name='to_world'>^<scale value='0'/><rotate ^angle='right' x='1'/></transform>"
     "<film type='hdrfilm'>^<string name='pixel_format' value='rgbx'/></film></sensor>",
     {"sensor 'thinlens' needs parameter 'aperture_radius'", "'x' is not a number",
      "sensor 'thinlens' has no parameter 'fvo'", "<scale> makes", "'right' is not an angle",
      "'pixel_format' must be one of"}},
    {"ObjectsAndTheirParts",
     "<shape type='sphere'>^<float name='radius' value='-1'/>"
     "<bsdf type='diffuse'>^<float name='x' value='1'/></bsdf>"
     "<emitter type='area'>^<rgb name='radiance' value='-1'/></emitter></shape>",
     {"'radius' must be positive", "bsdf 'diffuse' has no parameter 'x'",
      "'radiance' must be between"}},
    {"PartsOfAnUnknownTag",
     "<shape type='sphere'>^<transfrom name='to_world'><scale value='x'/><float name='a' "
     "^value='b'/>"
     "</transfrom></shape>",
     {"unknown tag <transfrom> (did you mean 'transform'?)", "'b' is not a number"}},
    {"PartsOfAnUnknownPlugin",
     "<shape ^type='spher'><float name='radius' ^value='1m'/>"
     "<bsdf type='diffuse'>^<float name='x' value='1'/></bsdf></shape>",
     {"unknown shape plugin 'spher'", "'1m' is not a number",
      "bsdf 'diffuse' has no parameter 'x'"}},
    {"UnusedDefines",
     "!<bsdf type='diffuse'/>",
     {"the scene doesn't use -D a (it uses none)", "the scene doesn't use -D b"},
     {{"a", "1"}, {"b", "1"}}},
};

void PrintTo(const Several& several, std::ostream* stream) {
  *stream << several.xml;
}

class SeveralFaults : public testing::TestWithParam<Several> {};

TEST_P(SeveralFaults, AreAllNamedAndNoOthers) {
  const bool without_places = GetParam().xml[0] == '!';
  std::string xml =
      "<scene version='3.0.0'>" + std::string(GetParam().xml + without_places) + "</scene>";
  std::vector<std::string> places;
  int line = 1, column = 1;
  for (size_t i = 0; i < xml.size();) {
    if (xml[i] == '^') {
      places.push_back("scene.xml:" + std::to_string(line) + ":" + std::to_string(column) + ": ");
      xml.erase(i, 1);
      continue;
    }
    column = xml[i] == '\n' ? 1 : column + 1;
    line += xml[i++] == '\n';
  }
  if (without_places) places.assign(GetParam().messages.size(), "scene.xml: ");
  LoadOptions options;
  options.defines = GetParam().defines;
  const std::vector<std::string> found =
      errors_of([&] { load_scene_from_string(xml, "scene.xml", options, probe_registry()); });
  std::string list;
  for (const std::string& text : found) list += text + "\n";
  ASSERT_EQ(found.size(), places.size()) << list;
  for (size_t i = 0; i < found.size(); ++i) {
    const std::string expected = places[i] + GetParam().messages[i];
    EXPECT_EQ(found[i].substr(0, expected.size()), expected) << list;
  }
}

INSTANTIATE_TEST_SUITE_P(Table, SeveralFaults, testing::ValuesIn(kSeveral),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace kinome::test::several_errors_test
