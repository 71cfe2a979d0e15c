/*
 * Walks over the elements of an XML text, without a tree: what a model asks for is looked at before MuJoCo reads it.
 *
 *     struct vehicle_xml xml = vehicle_xml_begin(text, length);
 *     while ((event = vehicle_xml_next(&xml)) == VEHICLE_XML_OPEN || event == VEHICLE_XML_CLOSE)
 *             while (vehicle_xml_attribute(&xml, &attribute))
 *
 * A text that it does not understand is VEHICLE_XML_BAD: to refuse it is safe.
 */
#ifndef FURROW_VEHICLE_XML_H
#define FURROW_VEHICLE_XML_H

#include <stdbool.h>
#include <stddef.h>

enum vehicle_xml_event { VEHICLE_XML_OPEN, VEHICLE_XML_CLOSE, VEHICLE_XML_DONE, VEHICLE_XML_BAD };

struct vehicle_xml {
	const char *at, *end;
	const char *name; /* of the element that was opened or closed; not ended by a NUL */
	size_t name_length;
	const char *next_attribute, *attributes_end;
	int depth;   /* elements that are open, with this one */
	bool single; /* the element closes itself, and its end is due */
};

struct vehicle_xml_attribute {
	const char *name, *value; /* not ended by a NUL; the value is as it is written */
	size_t name_length, value_length;
};

struct vehicle_xml vehicle_xml_begin(const char *text, size_t length);
enum vehicle_xml_event vehicle_xml_next(struct vehicle_xml *xml);
/* Gives the next attribute of the element that was opened last. Returns false if there is none. */
bool vehicle_xml_attribute(struct vehicle_xml *xml, struct vehicle_xml_attribute *out);
/* Returns true if a name of the text is `name`. */
bool vehicle_xml_is(const char *found, size_t length, const char *name);

#endif
