/*
 * Keeps GDAL off networks. A raster, a VRT, the SRS of a file may name an address, and GDAL would fetch it.
 *
 * GDAL has two ways: what fetches whole answers asks a function that may be replaced, for the process or for a thread. What reads
 * files in parts (/vsicurl and its kin) reads only the names that an option allows. Both are set. A host's own calls of GDAL are
 * not touched: a thread's settings hold only between dem_quiet_begin and dem_quiet_end.
 */
#include <stdatomic.h>

#include "dem_gdal.h"

#define NAMES "CPL_VSIL_CURL_ALLOWED_FILENAME"
#define NONE "/none"

static atomic_int opened;          /* calls of dem_network_begin that have not ended */
static atomic_bool process_closed; /* dem_network_close_process was called */
static _Thread_local int closed;   /* calls of dem_network_close_thread in this thread */
static _Thread_local char before[512];
static _Thread_local bool had_before, is_set;

static CPLHTTPResult *fetch_nothing(const char *url, CSLConstList options, GDALProgressFunc progress, void *progress_user,
				    CPLHTTPFetchWriteFunc write, void *write_user, void *user)
{
	(void)url, (void)options, (void)progress, (void)progress_user, (void)write, (void)write_user, (void)user;
	CPLHTTPResult *result = VSICalloc(1, sizeof *result); /* GDAL frees it */
	if (result == NULL)
		return NULL;
	result->nStatus = 1;
	result->pszErrBuf = VSIStrdup("a network is not used");
	return result;
}

bool dem_network_is_open(void)
{
	return atomic_load(&opened) > 0;
}

static void set_process(bool close)
{
	CPLHTTPSetFetchCallback(close ? fetch_nothing : NULL, NULL);
	CPLSetConfigOption(NAMES, close ? NONE : NULL);
	OSRSetPROJEnableNetwork(!close);
}

void dem_network_close_process(void)
{
	atomic_store(&process_closed, true);
	if (!dem_network_is_open())
		set_process(true);
}

static void set_thread(bool close)
{
	if (is_set == close)
		return;
	is_set = close;
	if (close) {
		const char *names = CPLGetThreadLocalConfigOption(NAMES, NULL);
		had_before = names != NULL;
		snprintf(before, sizeof before, "%s", had_before ? names : "");
		(void)CPLHTTPPushFetchCallback(fetch_nothing, NULL);
	} else {
		(void)CPLHTTPPopFetchCallback();
	}
	CPLSetThreadLocalConfigOption(NAMES, close ? NONE : had_before ? before : NULL);
}

/* While a network is allowed, threads that begin stay open. */
void dem_network_close_thread(void)
{
	if (closed++ == 0 && !dem_network_is_open())
		set_thread(true);
}

void dem_network_reopen_thread(void)
{
	if (--closed == 0)
		set_thread(false);
}

void dem_network_begin(void)
{
	set_thread(false);
	atomic_fetch_add(&opened, 1);
	if (atomic_load(&process_closed))
		set_process(false);
}

void dem_network_end(void)
{
	atomic_fetch_sub(&opened, 1);
	if (atomic_load(&process_closed) && !dem_network_is_open())
		set_process(true);
	if (closed > 0 && !dem_network_is_open())
		set_thread(true);
}

/* --- drivers --- */

static const char *const networked[] = {"WMS", "WMTS", "WCS", "HTTP", "PLMOSAIC", "PLSCENES", "DAAS", "EEDA", "EEDAI", "OGCAPI", "STACTA", "STACIT",
					"NGW", "PostGISRaster", "GeoRaster", "GTI", "KMLSUPEROVERLAY", "JPIPKAK", "DODS", "RASDAMAN"};

static bool is_networked(const char *name)
{
	for (size_t i = 0; i < sizeof networked / sizeof networked[0]; i++)
		if (strcmp(networked[i], name) == 0)
			return true;
	return false;
}

bool dem_gdal_is_networked(GDALDriverH driver)
{
	return is_networked(GDALGetDriverShortName(driver));
}

static const char *allowed[1024]; /* names that GDAL owns; ended by NULL */

static void list_drivers(void)
{
	const size_t most = sizeof allowed / sizeof allowed[0] - 1;
	size_t count = 0;
	for (int i = 0; i < GDALGetDriverCount() && count < most; i++) {
		const char *name = GDALGetDriverShortName(GDALGetDriver(i));
		if (!is_networked(name))
			allowed[count++] = name;
	}
}

const char *const *dem_gdal_drivers(void)
{
	static pthread_once_t once = PTHREAD_ONCE_INIT;
	if (dem_network_is_open())
		return NULL;
	pthread_once(&once, list_drivers);
	return allowed;
}
