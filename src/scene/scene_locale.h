/* Numbers with a point, whatever the process's locale writes in its place. */
#ifndef FURROW_SCENE_LOCALE_H
#define FURROW_SCENE_LOCALE_H

#include <locale.h>

#include "base/base.h"

struct scene_locale {
	locale_t plain, before;
};

/*
 * From begin to end, the calling thread reads and writes numbers as the C locale does. The process's locale
 * and all other threads keep theirs. End gives the thread back the locale that it had.
 */
enum status scene_locale_begin(struct scene_locale *locale) FURROW_CHECKED;
void scene_locale_end(struct scene_locale *locale);

#endif
