"""Tests of several processes that render one image over MPI: the bits are those of a single process
for any number, little is lost if one is killed, and errors are reported if they can't cooperate."""

import concurrent.futures
import os
import pathlib
import resource
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[4]
PROGRAM = pathlib.Path(os.environ.get("KINOME_BUILD", ROOT / "build")) / "bin/kinome"
CORNELL = ROOT / "validation/scenes/cornell.xml"
# Allows MPI to run as root, and any number of processes.
MPI = os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
MPIRUN = ["mpirun", "--oversubscribe"]
# The launcher kills processes that don't end within a second, which is too short on a busy machine.
PATIENT = ["--mca", "odls_base_sigkill_timeout", "6"]

# Bright and dark sides, a rough floor and a ball, so that the pilot of `clustered` has visibility
# to learn, and its trial has methods to compare (from 300,000 samples on).
SCENE = """<scene version="3.0.0">
  <default name="integrator" value="clustered"/> <default name="spp" value="40"/>
  <default name="width" value="112"/> <default name="height" value="72"/>
  <default name="cube" value="plastic"/>
  <integrator type="$integrator"/>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"> <lookat origin="0.3,1.1,5" target="0,0,0" up="0,1,0"/> </transform>
    <sampler type="ldsampler"> <integer name="sample_count" value="$spp"/> </sampler>
    <film type="hdrfilm"> <integer name="width" value="$width"/> <integer name="height" value="$height"/>
      <string name="component_format" value="float32"/> </film>
  </sensor>
  <emitter type="sunsky"/>
  <shape type="sphere"> <bsdf type="roughplastic"/> </shape>
  <shape type="cube"> <transform name="to_world"> <translate x="2.2"/> </transform>
    <bsdf type="$cube"/> </shape>
  <shape type="rectangle">
    <transform name="to_world"> <rotate x="1" angle="-90"/> <scale value="9"/>
      <translate y="-1"/> </transform>
    <bsdf type="roughconductor"> <float name="alpha" value="0.3"/> </bsdf>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"> <scale value="0.3"/> <translate x="-1" y="1.5" z="1"/> </transform>
    <emitter type="area"> <rgb name="radiance" value="9"/> </emitter>
  </shape>
</scene>
"""


def run(*arguments, launcher=(), **options):
    options = {"capture_output": True, "text": True, "timeout": 120, "env": MPI} | options
    return subprocess.run([*launcher, str(PROGRAM), *map(str, arguments)], **options)


def processes(count):
    return [*MPIRUN, "-n", str(count)]


def wait_for(job, text):
    """Waits until a line of the job's stderr begins with the text."""
    while not job.stderr.readline().startswith(text):
        if job.poll() is not None:
            raise AssertionError(f"it ended without '{text}'")


class MpiTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.scene = self.folder / "scene.xml"
        self.scene.write_text(SCENE)

    def picture(self, name, *arguments, launcher=()):
        """Returns the bytes of the file, including its header."""
        path = self.folder / name
        done = run(*arguments, "-q", "-o", path, launcher=launcher)
        self.assertEqual(done.returncode, 0, done.stderr)
        return path.read_bytes()

    def processes_of(self, argument):
        found = subprocess.run(["pgrep", "-f", f"^{PROGRAM}.*{argument}"], text=True,
                               capture_output=True, check=False).stdout.split()
        return sorted(map(int, found))

    def assert_same_bits(self, arguments, *groups):
        alone = self.picture("alone.exr", *arguments)
        for count, threads in groups:
            with self.subTest(arguments=arguments, processes=count, threads=threads):
                together = self.picture("together.exr", *arguments, "-t", threads,
                                        launcher=processes(count))
                self.assertEqual(alone, together)

    def test_clustered_has_the_same_bits(self):
        self.assert_same_bits([self.scene], (2, 1), (3, 2))
        # Lanes; a trial that chooses paths; bands of the image that are learned one after another.
        self.assert_same_bits([self.scene, "--variance=4"], (3, 1))
        self.assert_same_bits([self.scene, "-Dcube=dielectric"], (2, 1))
        self.assert_same_bits([self.scene, "-Dwidth=320", "-Dheight=300", "-Dspp=4"], (3, 1))

    def test_other_integrators_have_the_same_bits(self):
        self.assert_same_bits([CORNELL], (3, 2))
        self.assert_same_bits([CORNELL, "-Dintegrator=ptracer"], (3, 1))
        self.assert_same_bits([CORNELL, "--error=0.1"], (2, 1))
        self.assert_same_bits([ROOT / "validation/scenes/moment.xml"], (2, 2))

    def test_more_processes_than_work(self):
        self.assert_same_bits([CORNELL, "-Dspp=1"], (12, 1))

    def test_a_time_and_the_report_are_of_all(self):
        done = run(self.scene, "--time=1", "--stats", "-o", self.folder / "a.exr",
                   launcher=processes(2))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 processes, ", done.stderr)
        self.assertRegex(done.stderr, r"sent: items +[1-9]\d* messages")
        self.assertEqual(done.stderr.count("wrote "), 1)

    def test_resumes_after_a_kill_with_another_number_of_processes(self):
        for victim in range(2):
            # A fast machine may finish few samples before a process can be killed.
            for samples in (1024, 4096, 16384):
                scene = [CORNELL, f"-Dspp={samples}"]
                kept = self.folder / f"{victim}-{samples}.ck"
                keep = [*scene, "--checkpoint", kept, "--every=0.05", "-t1"]
                if self.is_killed(victim, kept, keep):
                    break
            else:
                self.fail("the image was done before a process could be killed")
            resumed = self.picture("resumed.exr", *keep, "--resume", launcher=processes(2))
            self.assertEqual(self.picture("alone.exr", *scene), resumed)

    def is_killed(self, victim, kept, keep):
        """Renders with three processes and kills one of them after the first checkpoint. Returns
        False if the image is finished before."""
        with subprocess.Popen([*processes(3), PROGRAM, *map(str, keep), "-q", "-o",
                               self.folder / "killed.exr"], env=MPI,
                              stderr=subprocess.PIPE, text=True) as job:
            while not kept.exists() and job.poll() is None:
                time.sleep(0.01)
            found = self.processes_of(kept)
            if len(found) < 3:
                job.communicate(timeout=600)
                return False
            os.kill(found[victim], signal.SIGKILL)
            message = job.communicate(timeout=600)[1]
        self.assertNotEqual(job.returncode, 0)
        self.assertRegex(message, "process rank [0-2] .*Killed")
        return True

    def test_an_interrupted_launcher_leaves_an_image(self):
        # The launchers run at the same time, because each waits for its whole timeout.
        with concurrent.futures.ThreadPoolExecutor() as pool:
            list(pool.map(self.check_interrupted_launcher, ("path", "clustered", "ptracer")))

    def check_interrupted_launcher(self, integrator):
        path, kept = (self.folder / f"{integrator}.{suffix}" for suffix in ("exr", "checkpoint"))
        command = [*processes(2), *PATIENT, PROGRAM, CORNELL, "-Dspp=65536", "-t1", "-v",
                   f"-Dintegrator={integrator}", "-o", path, "--checkpoint", kept]
        with subprocess.Popen(command, env=MPI, stderr=subprocess.PIPE, text=True) as job:
            wait_for(job, "kinome: rendering ")
            time.sleep(1)
            job.send_signal(signal.SIGINT)
            message = job.communicate(timeout=600)[1]
        self.assertNotEqual(job.returncode, 0, integrator)
        self.assertEqual(message.count("wrote "), 1, f"{integrator}: {message}")
        self.assertTrue(path.exists() and kept.exists(), integrator)

    def assert_refused(self, status, message, what):
        self.assertNotEqual(status, 0)
        lines = [line for line in message.splitlines()
                 if line.startswith("kinome: ") and "warning: " not in line]
        self.assertEqual(len(lines), 1, message)
        self.assertRegex(lines[0], what)

    def together(self, *lines, env=MPI):
        """Runs processes with different command lines."""
        command = list(MPIRUN)
        for line in lines:
            command += [*([":"] if len(command) > len(MPIRUN) else []), "-n", "1", str(PROGRAM),
                        *map(str, line)]
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=1200,
                              check=False)
        return done.returncode, done.stderr

    def test_differing_processes_are_refused(self):
        output = ["-o", self.folder / "a.exr"]
        missing = self.folder / "missing.xml"
        # The file is missing for one process, then for all.
        self.assert_refused(*self.together([CORNELL, *output], [missing, *output]),
                            "rank 1 on .*missing.xml")
        self.assert_refused(*self.together([missing, *output], [missing, *output]),
                            "kinome: .*missing.xml")
        self.assert_refused(*self.together([CORNELL, *output], [self.scene, *output]),
                            "rank 1 on .* would render a different image: its .*'112x72'")
        self.assert_refused(*self.together([CORNELL, *output], [CORNELL, "--seed=1", *output]),
                            "rank 1 .* its seed is '1', but that of rank 0 on .* is '0'")
        # Numbers of threads may differ, but not options that determine when processes exchange
        # data.
        self.assert_refused(*self.together([CORNELL, *output], [CORNELL, "--time=1", *output]),
                            "rank 1 on .*its --time is '1'")
        self.assertFalse((self.folder / "a.exr").exists())
        self.assertEqual(self.together([CORNELL, "-t1", *output], [CORNELL, *output])[0], 0)
        wrong = self.folder / "wrong.xml"
        wrong.write_text(SCENE.replace("sunsky", "nosuch").replace("cube", "cupe"))
        alone = run(wrong).stderr
        for line in run(wrong, launcher=processes(2)).stderr.splitlines():
            if line.startswith("kinome: "):
                self.assertIn(line, alone.splitlines())
        for arguments, what in (([CORNELL, "-o", self.folder / "nowhere/a.exr"], "nowhere"),
                                ([CORNELL, "--inspect=1,1"], "--inspect"),
                                (["film", CORNELL, "--path=orbit", "--frames=2"], "film")):
            done = run(*arguments, launcher=processes(2))
            self.assert_refused(done.returncode, done.stderr, what)

    def test_a_full_disk_is_one_error(self):
        # The limit is set after MPI has written its own files.
        path = self.folder / "a.exr"
        with subprocess.Popen([*processes(2), PROGRAM, CORNELL, "-Dspp=1024", "-t1", "-v", "-o", path],
                              env=MPI, stderr=subprocess.PIPE, text=True) as job:
            wait_for(job, "kinome: rendering ")
            for process in self.processes_of(path):
                resource.prlimit(process, resource.RLIMIT_FSIZE, (500, 500))
            message = job.communicate(timeout=600)[1]
        self.assert_refused(job.returncode, message, "a.exr")
        self.assertEqual([p.name for p in self.folder.iterdir()], ["scene.xml"])

    def test_mpi_is_loaded_only_where_it_is_needed(self):
        loads = MPI | {"LD_DEBUG": "files"}
        done = run(CORNELL, "-Dspp=1", "-o", self.folder / "a.exr", env=loads)
        self.assertNotIn("libmpi", done.stderr)
        for mode, loaded in (("auto", True), ("off", False)):
            lines = [[CORNELL, "-Dspp=1", f"--mpi={mode}", "-o", self.folder / name]
                     for name in ("a.exr", "b.exr")]
            self.assertEqual("libkinome_mpi" in self.together(*lines, env=loads)[1], loaded)
            # Separate processes write separate files.
            self.assertNotEqual((self.folder / "b.exr").exists(), loaded)
        alone = self.picture("alone.exr", CORNELL)
        self.assertEqual(alone, self.picture("one.exr", CORNELL, "--mpi=on"))

    def test_an_interrupted_process_is_everyones(self):
        path = self.folder / "interrupted.exr"
        with subprocess.Popen([*processes(2), PROGRAM, CORNELL, "-Dspp=65536", "-t1", "-v", "-o", path],
                              env=MPI, stderr=subprocess.PIPE, text=True) as job:
            wait_for(job, "kinome: rendering ")
            time.sleep(1)
            os.kill(self.processes_of(path)[1], signal.SIGINT)
            message = job.communicate(timeout=600)[1]
        self.assertEqual(job.returncode, 130, message)
        self.assertIn("incomplete", message)

    def test_a_launcher_of_another_mpi_is_refused(self):
        # The environment reports two processes, and MPI, which doesn't support that launcher,
        # reports one.
        done = run(CORNELL, "-o", self.folder / "a.exr",
                   env=MPI | {"PMI_RANK": "0", "PMI_SIZE": "2"})
        self.assert_refused(done.returncode, done.stderr, "different MPI versions")

    def test_plugins_are_listed_once(self):
        done = run("plugins", "path", launcher=processes(3))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, run("plugins", "path").stdout)


if __name__ == "__main__":
    unittest.main()
