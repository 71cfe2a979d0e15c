/* What a file names is not fetched on a thread of the library; a host's own settings of GDAL come back. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <arpa/inet.h>
#include <cpl_conv.h>
#include <pthread.h>
#include <sys/socket.h>

#include "files.h"
#include "../support/program.h"

#define NAMES "CPL_VSIL_CURL_ALLOWED_FILENAME"

static int listener;
static int calls; /* written by the listener's thread, which ends a call before it is answered */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void *serve(void *nothing)
{
	static const char answer[] = "HTTP/1.0 200 OK\r\nContent-Length: 9\r\n\r\nEPSG:4326";
	char request[4096];
	int call;
	while ((call = accept(listener, NULL, NULL)) >= 0) {
		pthread_mutex_lock(&lock);
		calls++;
		pthread_mutex_unlock(&lock);
		if (read(call, request, sizeof request) > 0)
			(void)!write(call, answer, sizeof answer - 1);
		close(call);
	}
	return NULL;
}

static int called(void)
{
	pthread_mutex_lock(&lock);
	const int now = calls;
	pthread_mutex_unlock(&lock);
	return now;
}

/* A line whose SRS is an address: GDAL fetches it when it opens the file. */
static void read_line(void)
{
	struct sockaddr_in at = {.sin_family = AF_INET};
	socklen_t size = sizeof at;
	char text[600];
	struct dem_line line;
	assert_int_equal(getsockname(listener, (struct sockaddr *)&at, &size), 0);
	const int length = snprintf(text, sizeof text,
				    "{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"link\",\"properties\":{\"href\":\"http://127.0.0.1:%d/x\",\"type\":\"proj4\"}},"
				    "\"features\":[{\"type\":\"Feature\",\"properties\":{},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[[1,2],[1.1,2]]}}]}",
				    ntohs(at.sin_port));
	write_file("line.geojson", text, (size_t)length);
	if (dem_line_read(in_folder("line.geojson"), "line", 0, &line) == STATUS_OK)
		dem_line_finish(&line);
}

static void nothing_is_fetched_between_begin_and_end(void **state)
{
	struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
	pthread_t thread;
	listener = socket(AF_INET, SOCK_STREAM, 0);
	assert_int_equal(bind(listener, (struct sockaddr *)&at, sizeof at), 0);
	assert_int_equal(listen(listener, 10), 0);
	assert_int_equal(pthread_create(&thread, NULL, serve, NULL), 0);
	setenv("NO_PROXY", "*", 1);
	CPLSetThreadLocalConfigOption(NAMES, "the host's");
	dem_quiet_begin();
	read_line();
	assert_int_equal(called(), 0);
	assert_string_equal(CPLGetThreadLocalConfigOption(NAMES, ""), "/none");
	dem_quiet_begin(); /* nested */
	read_line();
	dem_quiet_end();
	read_line();
	assert_int_equal(called(), 0);
	dem_network_begin();
	read_line();
	const int allowed = called();
	assert_true(allowed > 0);
	dem_network_end();
	read_line();
	assert_int_equal(called(), allowed);
	dem_quiet_end();
	assert_string_equal(CPLGetThreadLocalConfigOption(NAMES, ""), "the host's");
	read_line(); /* of the host itself */
	assert_true(called() > allowed);
	CPLSetThreadLocalConfigOption(NAMES, NULL);
	shutdown(listener, SHUT_RDWR);
	close(listener);
	pthread_join(thread, NULL);
}

static void texts_of_an_srs_lead_nowhere(void **state)
{
	static const char *const good[] = {
		"EPSG:32633", "IAU_2015:49900", "  EPSG:4326", "WGS84", "urn:ogc:def:crs:EPSG::4326", "http://www.opengis.net/def/crs/EPSG/0/4326",
		"+proj=utm +zone=33", "+proj=merc +a=6378137 +b=6378137 +nadgrids=@null +units=m", "OGC:CRS84", "EPSG:4326+3855",
		"GEOGCS[\"a / b\",DATUM[\"D\",SPHEROID[\"S\",6378137,298]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]",
	};
	static const char *const bad[] = {
		"http://127.0.0.1:1/x", "https://example.invalid/def/crs", "/etc/hostname", "./x", "../x", "~/x", "DICT:x,1", "/vsicurl/http://127.0.0.1:1/",
		"+proj=utm +zone=33 +nadgrids=/x", "+proj=utm +zone=33 +nadgrids=@../x", "+init=/x:1", "+init=x/../../y:1",
		"+proj=pipeline +step +proj=gridshift +grids=./x", "+proj=tinshift +file=/x", "+proj=longlat +geoidgrids=http://127.0.0.1:1/x",
		"VERT_CS[\"v\",VERT_DATUM[\"d\",2005,EXTENSION[\"PROJ4_GRIDS\",\"/x\"]],UNIT[\"m\",1]]",
		"ftp://127.0.0.1/x",
	};
	double x = 15, y = 45;
	for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
		double at[2] = {x, y};
		if (dem_transform(good[i], "EPSG:4326", 1, &at[0], &at[1]) != STATUS_OK && strstr(failure_message(), "none is opened") != NULL)
			fail_msg("%s: %s", good[i], failure_message());
	}
	for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
		assert_int_equal(dem_transform(bad[i], "EPSG:4326", 1, &x, &y), STATUS_INPUT);
		if (strstr(failure_message(), "none is opened") == NULL && strstr(failure_message(), "nothing is fetched") == NULL)
			fail_msg("%s: %s", bad[i], failure_message());
	}
}

TEST_PROGRAM(network)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(nothing_is_fetched_between_begin_and_end),
		cmocka_unit_test(texts_of_an_srs_lead_nowhere),
	};
	return cmocka_run_group_tests_name("dem/network", tests, folder_make, folder_remove);
}
