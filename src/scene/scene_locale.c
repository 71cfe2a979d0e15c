/* Sets the locale of the thread to "C" while a scene is read, and restores it afterwards. */
#include "scene/scene_locale.h"

enum status scene_locale_begin(struct scene_locale *locale)
{
	locale->plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
	if (locale->plain == (locale_t)0)
		return fail_memory("a locale for numbers");
	locale->before = uselocale(locale->plain);
	return STATUS_OK;
}

void scene_locale_end(struct scene_locale *locale)
{
	uselocale(locale->before);
	freelocale(locale->plain);
}
