/* Makes numbers use a decimal point, even if the locale of the process uses a comma. */
#ifndef FURROW_SCENE_LOCALE_H
#define FURROW_SCENE_LOCALE_H

#include <locale.h>

#include "base/base.h"

struct scene_locale {
	locale_t plain, before;
};

/*
 * Between begin and end, the calling thread reads and writes numbers as in the C locale. The locale of the process and of other
 * threads does not change. scene_locale_end restores the thread's earlier locale.
 */
enum status scene_locale_begin(struct scene_locale *locale) FURROW_CHECKED;
void scene_locale_end(struct scene_locale *locale);

#endif
