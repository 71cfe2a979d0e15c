/* Models that ask for more than a vehicle needs, or for files out of their reach: refused before MuJoCo reads them. */
#include <sys/stat.h>
#include <unistd.h>

#include "../support.h"
#include "../support/program.h"
#include "vehicle/check.h"

static void write_model(const char *name, const char *format, ...) FURROW_PRINTF(2, 3);
static void write_model(const char *name, const char *format, ...)
{
	va_list args;
	va_start(args, format);
	FILE *file = fopen(support_path(name), "w");
	assert_non_null(file);
	vfprintf(file, format, args);
	va_end(args);
	assert_int_equal(fclose(file), 0);
}

static enum status check(void)
{
	bool urdf, welded;
	return vehicle_check_model("scene.yaml: vehicles.car", support_path("m/n/model.xml"), &urdf, &welded);
}

static void assert_refused(const char *what, const char *why)
{
	if (check() != STATUS_INPUT)
		fail_msg("%s was taken, or failed otherwise", what);
	if (strncmp(failure_message(), "scene.yaml: vehicles.car: ", 26) != 0 || strstr(failure_message(), why) == NULL)
		fail_msg("%s: \"%s\" does not say \"%s\"", what, failure_message(), why);
}

static void refused(const char *inside, const char *why)
{
	write_model("m/n/model.xml", "<mujoco>%s</mujoco>", inside);
	assert_refused(inside, why);
}

static void taken(const char *inside)
{
	write_model("m/n/model.xml", "<mujoco>%s</mujoco>", inside);
	if (check() != STATUS_OK)
		fail_msg("%s: %s", inside, failure_message());
}

static void numbers_have_limits(void **state)
{
	static const char *const cases[][2] = {
		{"<asset><hfield name='h' nrow='100000' ncol='100000' size='1 1 1 1'/></asset>", "nrow of hfield: 100000 is too much; allowed: 65536; lower it"},
		{"<asset><hfield name='h' nrow='30000' ncol='30000' size='1 1 1 1'/></asset>", "allowed: 268435456"},
		{"<asset><hfield nrow='4000' ncol='4000'/><hfield nrow='4000' ncol='4000'/><hfield nrow='4000' ncol='4000'/></asset>", "allowed: 268435456"},
		{"<size nuser_body=\"100000000\"/>", "nuser_body of size: 100000000 is too much; allowed: 1000"},
		{"<size nuser_body='1e300'/>", "nuser_body of size: 1e+300 is too much"},
		{"<size nuser_geom='nan'/>", "nuser_geom of size: nan is too much"},
		{"<size nuser_sensor='inf'/>", "nuser_sensor of size: inf is too much"},
		{"<size nuser_jnt='0x7fffffff'/>", "nuser_jnt of size: 2147483647 is too much"},
		{"<size nuser_jnt='&#57;99999'/>", "nuser_jnt of size: nan is too much"},
		{"<size\nnkey = '1001' />", "nkey of size"},
		{"<size njmax='100000'/>", "njmax of size: 100000 is too much; allowed: 5000"},
		{"<size nconmax='2000000000'/>", "nconmax of size"},
		{"<size nstack='2000000000'/>", "nstack of size"},
		{"<size nuserdata='2000000000'/>", "nuserdata of size"},
		{"<size memory='3G'/>", "memory of size"},
		{"<option iterations='2000000000'/>", "iterations of option"},
		{"<asset><texture builtin='flat' width='60000' height='60000' type='2d'/></asset>", "allowed: 268435456"},
		{"<asset><texture builtin='flat' width='10000' type='cube'/></asset>", "allowed: 268435456"},
		{"<custom><numeric name='n' size='2000000000'/></custom>", "size of numeric"},
		{"<worldbody><composite type='grid' count='1000 1000 1'/></worldbody>", "degrees of freedom"},
		{"<!-- <size nkey='1'/> --><size nkey='99999'/>", "nkey of size"},
		{"<size a='>' nkey='99999'/>", "nkey of size"},
		{"<worldbody><body>", "its XML is not whole"},
		{"<size nkey='99999", "its XML is not whole"},
		{"</mujoco></mujoco>", "its XML is not whole"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
		refused(cases[i][0], cases[i][1]);
	taken("<!-- <size nuser_body='100000000'/> --><![CDATA[<size nkey='99999'/>]]><size njmax='1000' nconmax='-1' nuser_geom='3'/>"
	      "<asset><hfield nrow='1000' ncol='1000'/><texture builtin='flat' width='512' height='3072'/></asset>");
}

static void many(const char *before, const char *part, int times, const char *after, const char *why)
{
	FILE *file = fopen(support_path("m/n/model.xml"), "w");
	assert_non_null(file);
	fprintf(file, "<mujoco>%s", before);
	for (int i = 0; i < times; i++)
		fputs(part, file);
	fprintf(file, "%s</mujoco>", after);
	assert_int_equal(fclose(file), 0);
	assert_refused(part, why);
}

static void elements_have_limits(void **state)
{
	many("", "<body>", 1000000, "", "elements in each other: 101 is too much; allowed: 100");
	many("<worldbody>", "<body/>", 10001, "</worldbody>", "bodies: 10001 is too much");
	many("<worldbody>", "<geom/>", 20001, "</worldbody>", "elements: 20001 is too much");
	many("<worldbody><body>", "<joint/>", 3001, "</body></worldbody>", "degrees of freedom of its joints and composites: 3001 is too much; allowed: 3000");
	many("<worldbody>", "<body><freejoint/></body>", 501, "</worldbody>", "degrees of freedom");
	many("<default><joint type='ball'/></default><worldbody><body>", "<joint/>", 1001, "</body></worldbody>", "degrees of freedom");
	many("<keyframe>", "<key/>", 1001, "</keyframe>", "keyframes: 1001");
}

static void files_are_beside_the_model(void **state)
{
	static const char *const cases[][2] = {
		{"<asset><mesh file='/etc/passwd'/></asset>", "\"/etc/passwd\": only names that are relative are followed; put the file beside the model"},
		{"<asset><mesh file='http://127.0.0.1/a.stl'/></asset>", "only names that are relative"},
		{"<asset><mesh file='../../outside.stl'/></asset>", "it lies neither in the model's folder nor in the one above"},
		{"<asset><mesh file='link.stl'/></asset>", "it lies neither in the model's folder"},
		{"<asset><mesh file='pipe.stl'/></asset>", "not a file"},
		{"<asset><hfield file='pipe.stl'/></asset>", "not a file"},
		{"<asset><texture fileup='pipe.stl'/></asset>", "not a file"},
		{"<compiler meshdir='/dev'/><asset><mesh file='zero'/></asset>", "only names that are relative"},
		{"<asset><mesh file='x/pipe.stl'/></asset>", "not a file"}, /* with strippath */
		{"<compiler meshdir='../..'/><asset><mesh file='outside.stl'/></asset>", "it lies neither in the model's folder"},
		{"<include file='pipe.stl'/>", "not a file"},
		{"<include file='model.xml'/>", "includes: 101 is too much"},
		{"<include file='none.xml'/>", "No such file"},
		{"<asset><texture file='big.png'/></asset>", "allowed: 268435456"},
		{"<asset><mesh file='a&amp;b.stl'/></asset>", "it has an &"},
		{"<include file='more.xml'/>", "nkey of size"},
	};
	static const unsigned char png[24] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xff\0\0\xff";
	write_model("outside.stl", "x");
	assert_int_equal(mkfifo(support_path("m/n/pipe.stl"), 0600), 0);
	assert_int_equal(symlink("/dev/zero", support_path("m/n/link.stl")), 0);
	write_model("m/n/more.xml", "<mujoco><size nkey='5000'/></mujoco>");
	FILE *file = fopen(support_path("m/n/big.png"), "wb");
	assert_int_equal(fwrite(png, 1, sizeof png, file), sizeof png);
	fclose(file);
	for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
		refused(cases[i][0], cases[i][1]);
	write_model("m/beside.stl", "x");
	write_model("m/n/good.xml", "<mujoco/>");
	taken("<include file='good.xml'/><asset><mesh file='none.stl'/><mesh file='../beside.stl'/></asset>");
	/* Those of a URDF are found first (urdf.c), then looked at. */
	char model[256];
	snprintf(model, sizeof model, "%s", support_path("m/n/model.xml"));
	assert_int_equal(vehicle_check_mesh_file("scene.yaml: vehicles.car", model, support_path("m/n/pipe.stl"), "package://robot/pipe.stl"), STATUS_INPUT);
	assert_non_null(strstr(failure_message(), "not a file"));
}

static void faces_of_an_obj_have_corners(void **state)
{
	static const char *const bad[] = {"f 1 2 5", "f 1 2 99999999", "f -9 -99 -999", "f 1 2 0", "f 1/2 2 3", "f 1//2 2 3", "f 1/1/1/1 2 3", "f 1 2 x",
					  "f 1 2 3.5", "f 1 2 99999999999999999999", "f -5 1 2", "\tf 1 2 5", "f\t1 2 5", "f 1 2 \\\n9"};
	static const char *const good[] = {"f 1 2 3 4", "f -1 -2 -3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1\r", "# f 1 2 9", "l 1 2"};
	const char *model = "<asset><mesh file='a.obj'/></asset>";
	for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
		write_model("m/n/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 1\n%s\n", bad[i]);
		write_model("m/n/model.xml", "<mujoco>%s</mujoco>", model);
		assert_refused(bad[i], "\"a.obj\": ");
	}
	for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
		write_model("m/n/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvn 0 0 1\n%s\n", good[i]);
		taken(model);
	}
	FILE *file = fopen(support_path("m/n/a.obj"), "w");
	assert_non_null(file);
	fputs("v 0 0 0\nf", file);
	for (int i = 0; i < 1001; i++)
		fputs(" 1", file);
	fclose(file);
	refused(model, "more than 1000 corners");
	refused("<asset><mesh vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'/></asset>", "names a vertex that is not there");
	refused("<asset><mesh face='0 1 -5' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/></asset>", "names a vertex that is not there");
	refused("<asset><mesh file='none.stl' face='0 1 99999999'/></asset>", "names a vertex that is not there");
	taken("<asset><mesh vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 3'/></asset>");
	taken("<asset><skin file='a.skn'/></asset>"); /* it is taken out */
	for (int32_t corner = -1; corner < 5; corner++) {
		int32_t words[4 + 12 + 3] = {4, 0, 0, 1};
		words[18] = corner;
		file = fopen(support_path("m/n/a.msh"), "wb");
		assert_non_null(file);
		assert_int_equal(fwrite(words, sizeof words, 1, file), 1);
		fclose(file);
		if (corner >= 0 && corner < 4)
			taken("<asset><mesh file='a.msh'/></asset>");
		else
			refused("<asset><mesh file='a.msh'/></asset>", "a corner that is not there");
	}
}

static int enter(void **state)
{
	return support_enter(state) != 0 || mkdir(support_path("m"), 0700) != 0 || mkdir(support_path("m/n"), 0700) != 0;
}

TEST_PROGRAM(hostile)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(numbers_have_limits),
		cmocka_unit_test(elements_have_limits),
		cmocka_unit_test(files_are_beside_the_model),
		cmocka_unit_test(faces_of_an_obj_have_corners),
	};
	return cmocka_run_group_tests_name("vehicle/hostile", tests, enter, support_leave);
}
