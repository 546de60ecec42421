#include <gtest/gtest.h>

#include <filesystem>

#include "support/plugins/probe_registry.h"
#include "support/render.h"

/// Tests files that a scene reads: includes, search paths, spectra; and the scene's hash.
namespace kinome::test::scene_files_test {
namespace {

namespace fs = std::filesystem;

std::string scene(const std::string& children) {
  return "<scene version=\"3.0.0\">" + children + "</scene>";
}

std::unique_ptr<Scene> load(const std::string& path, const LoadOptions& options = {},
                            RenderStats* stats = nullptr) {
  return load_scene(path, options, probe_registry(), stats);
}

std::string load_error(const std::string& path, const LoadOptions& options = {}) {
  return error_of([&] { load(path, options); });
}

std::string shape_id(const Scene& loaded) {
  return loaded.shapes().at(0)->id();
}

/// Returns a shape with this id, so that a test can see which file or value was used.
std::string marker(const std::string& id) {
  return "<shape type='sphere' id='" + id + "'/>";
}

TEST(Files, MissingAndUnreadable) {
  const TemporaryFolder folder;
  EXPECT_EQ(load_error(folder.path("no.xml")), folder.path("no.xml") + ": no such file");
  EXPECT_EQ(load_error(folder.folder()), folder.folder() + ": it is a folder, not a file");
}

TEST(Files, MayHaveCommentsAroundTheRoot) {
  EXPECT_EQ(
      load_error(TemporaryFolder().write("a.xml",
                                         "\xEF\xBB\xBF<?xml version='1.0'?>\n<!-- before -->\n"
                                         "<scene version='3.0.0'/>\n<!-- after --> \n<?after?>\n")),
      "no error");
}

/// Returns the text in UTF-16 or UTF-32.
std::string encoded(const std::u32string& text, size_t unit, bool is_big_endian, bool has_mark) {
  std::string bytes;
  const auto add = [&](uint32_t value) {
    for (size_t k = 0; k < unit; ++k) {
      const size_t shift = 8 * (is_big_endian ? unit - 1 - k : k);
      bytes += static_cast<char>(value >> shift & 0xff);
    }
  };
  if (has_mark) add(0xfeff);
  for (const char32_t c : text) {
    if (unit == 2 && c > 0xffff) {
      add(0xd800 + ((c - 0x10000) >> 10));
      add(0xdc00 + ((c - 0x10000) & 0x3ff));
    } else {
      add(c);
    }
  }
  return bytes;
}

/// Columns count characters, in any encoding.
TEST(Files, MayBeUtf16OrUtf32) {
  const TemporaryFolder folder;
  const std::u32string text =
      U"<scene version='3.0.0'>\n<!-- \u00e4\u20ac\U0001d11e --><shape type='no'/></scene>";
  for (const size_t unit : {2u, 4u}) {
    for (const bool is_big_endian : {false, true}) {
      for (const bool has_mark : {false, true}) {
        SCOPED_TRACE(testing::Message() << unit << is_big_endian << has_mark);
        const std::string file =
            folder.write("a.xml", encoded(text, unit, is_big_endian, has_mark));
        const std::string error = load_error(file);
        EXPECT_NE(error.find(file + ":2:20: "), std::string::npos) << error;
      }
    }
  }
}

TEST(Files, MayBeLatin1) {
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "a.xml", "<?xml version='1.0' encoding='ISO-8859-1'?>\n<scene version='3.0.0'>"
               "<shape type='sphere'><ref id='\xe4'/></shape></scene>");
  EXPECT_EQ(load_error(file), file + ":2:50: unknown id '\xc3\xa4'");
}

TEST(Files, AnUnclosedElementIsNamed) {
  const TemporaryFolder folder;
  const std::string begin = "<scene version='3.0.0'>\n<!-- <a> -->\n<shape type='sphere' id='/>'>\n";
  const auto message = [&](const std::string& rest) {
    return load_error(folder.write("a.xml", begin + rest));
  };
  const std::string file = folder.path("a.xml");
  const std::string mismatch = "malformed XML: Start-end tags mismatch: ";
  EXPECT_EQ(message("<bsdf type='diffuse'/></scene>"),
            file + ":4:25: " + mismatch + "<shape> in line 3 isn't closed");
  EXPECT_EQ(message("<bsdf type='diffuse'></shape></scene>"),
            file + ":4:24: " + mismatch + "<bsdf> in line 4 isn't closed");
}

TEST(Include, DissolvesScenes) {
  const TemporaryFolder folder;
  folder.write("part.xml", scene(marker("a") + marker("b")));
  const auto loaded =
      load(folder.write("main.xml", scene("<include filename='part.xml'/>" + marker("c"))));
  ASSERT_EQ(loaded->shapes().size(), 3u);
  EXPECT_EQ(loaded->shapes()[1]->id(), "b");
  EXPECT_EQ(loaded->shapes()[2]->id(), "c");
}

TEST(Include, LoadsSingleObjectsAlsoInsideOfObjects) {
  const TemporaryFolder folder;
  folder.write("bsdf.xml", "<bsdf version='3.0.0' type='diffuse' id='red'/>");
  folder.write("properties.xml", scene("<float name='radius' value='3'/>"));
  const auto loaded =
      load(folder.write("main.xml", scene("<shape type='sphere'><include filename='bsdf.xml'/>"
                                          "<include filename='properties.xml'/></shape>")));
  EXPECT_EQ(loaded->shapes()[0]->bsdf().id(), "red");
  EXPECT_EQ(loaded->bounds().hi.x, 3.f);
}

TEST(Include, DefaultsCrossBothWays) {
  const TemporaryFolder folder;
  folder.write("part.xml", scene("<default name='b' value='from_part'/>" + marker("part_$a")));
  const auto loaded = load(folder.write(
      "main.xml", scene("<default name='a' value='from_main'/><include filename='part.xml'/>" +
                        marker("main_$b"))));
  EXPECT_EQ(loaded->shapes()[0]->id(), "part_from_main");
  EXPECT_EQ(loaded->shapes()[1]->id(), "main_from_part");
}

TEST(Include, SubstitutesItsFileName) {
  const TemporaryFolder folder;
  folder.write("part.xml", scene(marker("a")));
  LoadOptions options;
  options.defines["file"] = "part";
  const std::string path = folder.write("main.xml", scene("<include filename='$file.xml'/>"));
  EXPECT_EQ(shape_id(*load(path, options)), "a");
}

TEST(Include, UpgradesEachFileByItsOwnVersion) {
  const TemporaryFolder folder;
  folder.write("old.xml",
               "<scene version='0.5.0'><shape type='sphere'><transform name='toWorld'>"
               "<translate x='5'/></transform></shape></scene>");
  const auto loaded = load(folder.write("main.xml", scene("<include filename='old.xml'/>")));
  EXPECT_NEAR(loaded->bounds().hi.x, 6, 1e-5);
}

TEST(Include, NamesTheIncludedFileInErrors) {
  const TemporaryFolder folder;
  folder.write("part.xml", scene("\n  <shape type='spher'/>"));
  EXPECT_EQ(load_error(folder.write("main.xml", scene("<include filename='part.xml'/>"))),
            folder.path("part.xml") +
                ":2:10: unknown shape plugin 'spher' (did you mean 'sphere'?) "
                "(referenced by " +
                folder.path("main.xml") + ":1:33)");
}

TEST(Include, FaultsOfAllFilesAreNamedInTheOrderOfTheScene) {
  const TemporaryFolder folder;
  folder.write("inner.xml",
               scene("\n<shape type='ply'><string name='filename' value='a.ply'/></shape>"));
  folder.write("outer.xml", scene("<include filename='inner.xml'/>\n<nonsense/>"));
  folder.write("broken.xml", "<scene version='3.0.0'>\n<shape>");
  folder.write("a.ply", "plie\n");
  const std::string main = folder.write(
      "main.xml", scene("\n<include filename='outer.xml'/>\n<include filename='broken.xml'/>\n"
                        "<shape type='sphere'><float name='radius' value='-1'/></shape>"));
  std::string list;
  for (const Error& error : check_scene(main, {}, probe_registry())) {
    list += std::string(error.what()) + "\n";
  }
  const std::string at = folder.folder() + "/";
  EXPECT_EQ(list,
            at + "a.ply:1:1: not a PLY file: expected 'ply' as its first line (referenced by " +
                at + "inner.xml:2:19, referenced by " + at + "outer.xml:1:33, referenced by " + at +
                "main.xml:2:10)\n" + at + "outer.xml:2:1: unknown tag <nonsense> (referenced by " +
                at + "main.xml:2:10)\n" + at +
                "broken.xml:2:7: malformed XML: Start-end tags mismatch: <shape> in line 2 isn't "
                "closed (referenced by " +
                at + "main.xml:3:10)\n" + at +
                "main.xml:4:22: 'radius' must be positive and finite, got -1\n");
  EXPECT_TRUE(
      check_scene(folder.write("good.xml", scene("<shape type='sphere'/>")), {}, probe_registry())
          .empty());
  EXPECT_EQ(check_scene(folder.path("no.xml"), {}, probe_registry()).at(0).what(),
            folder.path("no.xml") + ": no such file");
}

TEST(Include, ErrorsOfItsParametersNameNoAsset) {
  const TemporaryFolder folder;
  folder.write("part.xml", scene("<float name='radius' value='-1'/>"));
  EXPECT_EQ(load_error(folder.write(
                "main.xml", scene("<shape type='sphere'><include filename='part.xml'/></shape>"))),
            folder.path("part.xml") +
                ":1:24: 'radius' must be positive and finite, got -1 (referenced by " +
                folder.path("main.xml") + ":1:54)");
}

TEST(Include, MustNotIncludeItself) {
  const TemporaryFolder folder;
  const std::string self = folder.write("self.xml", scene("<include filename='self.xml'/>"));
  EXPECT_EQ(load_error(self), self + ":1:33: '" + self + "' includes itself");
  folder.write("a.xml", scene("<include filename='b.xml'/>"));
  folder.write("b.xml", scene("\n<include filename='./a.xml'/>"));
  EXPECT_EQ(load_error(folder.path("a.xml")), folder.path("b.xml") + ":2:10: '" + folder.folder() +
                                                  "/./a.xml' includes itself (referenced by " +
                                                  folder.path("a.xml") + ":1:33)");
}

TEST(Include, IsAtMost15Deep) {
  const TemporaryFolder folder;
  for (int i = 0; i < 16; ++i) {
    folder.write("f" + std::to_string(i) + ".xml",
                 scene("<include filename='f" + std::to_string(i + 1) + ".xml'/>"));
  }
  folder.write("f16.xml", scene(marker("end")));
  EXPECT_EQ(shape_id(*load(folder.path("f1.xml"))), "end");
  const std::string error = load_error(folder.path("f0.xml"));
  const std::string start = folder.path("f15.xml") +
                            ":1:33: includes are nested more than 15 deep (referenced by " +
                            folder.path("f14.xml") + ":1:33, referenced by ";
  EXPECT_EQ(error.substr(0, start.size()), start);
}

TEST(Include, EndsWhereFilesMultiply) {
  const TemporaryFolder folder;
  for (int i = 0; i < 15; ++i) {
    const std::string next = "<include filename='f" + std::to_string(i + 1) + ".xml'/>";
    folder.write("f" + std::to_string(i) + ".xml", scene(next + next));
  }
  folder.write("f15.xml", scene(""));
  EXPECT_NE(load_error(folder.path("f0.xml")).find("too many includes"), std::string::npos);
}

/// The image of a scene doesn't depend on the working directory, unless the file is nowhere else.
TEST(SearchPath, OrderIsSceneThenPathThenOptionsThenWorkingDirectory) {
  const TemporaryFolder folder;
  for (const char* place : {"cwd", "first", "second", "scene", "scene/path"}) {
    folder.write(std::string(place) + "/part.xml", scene(marker(place)));
  }
  const std::string path =
      folder.write("scene/main.xml", scene("<path value='path'/><include filename='part.xml'/>"));
  LoadOptions options;
  options.search_paths = {folder.path("first"), folder.path("second")};
  const fs::path before = fs::current_path();
  fs::current_path(folder.path("cwd"));
  for (const char* place : {"scene", "scene/path", "first", "second", "cwd"}) {
    EXPECT_EQ(shape_id(*load(path, options)), place);
    fs::remove(folder.path(std::string(place) + "/part.xml"));
  }
  EXPECT_EQ(load_error(path, options), path + ":1:53: there is no file 'part.xml'; looked in " +
                                           folder.path("scene") + ", " + folder.path("scene/path") +
                                           ", " + folder.path("first") + ", " +
                                           folder.path("second") + ", the working directory");
  fs::current_path(before);
}

TEST(SearchPath, PathAndTheIncludesFolderComeFirst) {
  const TemporaryFolder folder;
  folder.write("extra/part.xml", scene(marker("extra")));
  folder.write("option/part.xml", scene(marker("option")));
  folder.write("extra/inner.xml", scene("<include filename='leaf.xml'/>"));
  folder.write("extra/leaf.xml", scene(marker("extra_leaf")));
  folder.write("option/leaf.xml", scene(marker("option_leaf")));
  LoadOptions options;
  options.search_paths = {folder.path("option")};
  const std::string with_path =
      folder.write("main.xml", scene("<path value='extra'/><include filename='part.xml'/>"));
  EXPECT_EQ(shape_id(*load(with_path, options)), "extra");
  const std::string without =
      folder.write("main2.xml", scene("<include filename='extra/inner.xml'/>"));
  EXPECT_EQ(shape_id(*load(without, options)), "extra_leaf");
}

TEST(SearchPath, InnerIncludesComeBeforeOuterOnes) {
  const TemporaryFolder folder;
  folder.write("outer/middle.xml", scene("<include filename='inner/inner.xml'/>"));
  folder.write("outer/inner/inner.xml", scene("<include filename='leaf.xml'/>"));
  folder.write("outer/inner/leaf.xml", scene(marker("inner")));
  folder.write("outer/leaf.xml", scene(marker("outer")));
  const std::string path = folder.write(
      "main.xml", scene("<include filename='outer/middle.xml'/><include filename='leaf.xml'/>"));
  folder.write("leaf.xml", scene(marker("main")));
  const auto loaded = load(path);
  EXPECT_EQ(loaded->shapes().at(0)->id(), "inner");
  EXPECT_EQ(loaded->shapes().at(1)->id(), "main");  // not in the folder of the include
}

TEST(SearchPath, HoldsForFilesThatPluginsRead) {
  const TemporaryFolder folder;
  folder.write("maps/a.txt", "");
  folder.write("parts/b.txt", "");
  folder.write("parts/part.xml",
               "<texture version='3.0.0' type='probe' name='optional'>"
               "<string name='file' value='b.txt'/></texture>");
  const std::string xml =
      "<texture version='3.0.0' type='probe'><path value='maps'/>"
      "<texture type='probe' name='texture'><string name='file' value='a.txt'/></texture>"
      "<include filename='parts/part.xml'/></texture>";
  const auto probe = std::dynamic_pointer_cast<Probe>(
      load_object_from_string(xml, folder.path("main.xml"), {}, probe_registry()));
  EXPECT_EQ(std::dynamic_pointer_cast<Probe>(probe->texture)->file, folder.path("maps/a.txt"));
  EXPECT_EQ(std::dynamic_pointer_cast<Probe>(probe->optional)->file, folder.path("parts/b.txt"));
}

TEST(SpectrumFile, HasTwoColumnsAndComments) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("a.spd", "# wavelength value\n360 0.5\n\n  830, 0.5 # the end\n");
  const auto load_spectrum = [](const std::string& file) {
    return probe("<spectrum name='texture' filename='" + file + "'/>")->texture->mean();
  };
  EXPECT_NEAR(load_spectrum(path).y, 0.5, 1e-5);
  const std::string bad = folder.write("b.spd", "360 0.5\n400 a\n");
  EXPECT_EQ(error_of([&] { load_spectrum(bad); }),
            bad + ":2:1: '400:a' is not a wavelength and a value (referenced by probe.xml:1:64)");
  const std::string wide = folder.write("c.spd", "# one\n  360 0.5 7\n");
  EXPECT_EQ(error_of([&] { load_spectrum(wide); }),
            wide +
                ":2:3: a line of a spectrum file has a wavelength and a value, not '360 0.5 7' "
                "(referenced by probe.xml:1:64)");
  const std::string single = folder.write("d.spd", "360 0.5\n");
  EXPECT_EQ(error_of([&] { load_spectrum(single); }),
            single + ": a spectrum needs at least two wavelengths (referenced by probe.xml:1:64)");
}

TEST(Hash, DependsOnAllTextAndDefines) {
  const TemporaryFolder folder;
  const std::string main =
      scene("<default name='x' value='1'/><include filename='part.xml'/>" + marker("s$x"));
  const std::string path = folder.write("main.xml", main);
  folder.write("part.xml", scene(""));
  const std::string hash = load(path)->hash();
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(hash.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(load(path)->hash(), hash);

  LoadOptions options;
  options.defines["x"] = "1";
  const std::string defined = load(path, options)->hash();
  EXPECT_NE(defined, hash);
  options.defines["x"] = "2";
  EXPECT_NE(load(path, options)->hash(), defined);

  folder.write("part.xml", scene("<!-- another -->"));
  EXPECT_NE(load(path)->hash(), hash);
  folder.write("part.xml", scene(""));
  folder.write("main.xml", main + " ");
  EXPECT_NE(load(path)->hash(), hash);
}

}  // namespace
}  // namespace kinome::test::scene_files_test
