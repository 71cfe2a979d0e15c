/* Where a map's picture lies on the ground, in files beside it that GDAL and QGIS read. */
#ifndef FURROW_TOOLS_WORLD_FILE_H
#define FURROW_TOOLS_WORLD_FILE_H

#include "chart/chart.h"
#include "store/store.h"

/* Writes NAME.pgw for the picture NAME.png: six lines, from pixels to metres of the store's system. If the store has a system, also
 * NAME.png.aux.xml, which names it. If one of them cannot be written, neither is. */
enum status world_file_write(const char *picture, const struct store_meta *meta, const struct chart_place *place) FURROW_CHECKED;

#endif
