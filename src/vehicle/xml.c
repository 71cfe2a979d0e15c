#include "vehicle/xml.h"

#include <string.h>

struct vehicle_xml vehicle_xml_begin(const char *text, size_t length)
{
	return (struct vehicle_xml){.at = text, .end = text + length};
}

bool vehicle_xml_is(const char *found, size_t length, const char *name)
{
	return strlen(name) == length && memcmp(found, name, length) == 0;
}

static bool is_space(char c)
{
	return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

static bool begins(const struct vehicle_xml *xml, const char *with)
{
	const size_t length = strlen(with);
	return (size_t)(xml->end - xml->at) >= length && memcmp(xml->at, with, length) == 0;
}

/* Goes on behind the next `mark`. Returns false if there is none. */
static bool skip_past(struct vehicle_xml *xml, const char *mark)
{
	const size_t length = strlen(mark);
	while (xml->at < xml->end && !begins(xml, mark))
		xml->at++;
	if (xml->at == xml->end)
		return false;
	xml->at += length;
	return true;
}

/* Goes to the end of a name. */
static const char *name_end(const char *at, const char *end)
{
	while (at < end && !is_space(*at) && *at != '>' && *at != '/' && *at != '=' && *at != '<' && *at != '"' && *at != '\'')
		at++;
	return at;
}

/* Finds the '>' that ends a tag: not one in quotes. */
static const char *tag_end(const char *at, const char *end)
{
	char quote = '\0';
	for (; at < end; at++) {
		if (quote != '\0')
			quote = *at == quote ? '\0' : quote;
		else if (*at == '"' || *at == '\'')
			quote = *at;
		else if (*at == '>')
			return at;
	}
	return NULL;
}

static enum vehicle_xml_event take_tag(struct vehicle_xml *xml)
{
	const bool closes = begins(xml, "</");
	const char *name = xml->at + (closes ? 2 : 1), *end = tag_end(name, xml->end), *rest = name_end(name, xml->end);
	if (end == NULL || rest == name || (closes && xml->depth == 0))
		return VEHICLE_XML_BAD;
	xml->name = name;
	xml->name_length = (size_t)(rest - name);
	xml->single = !closes && end[-1] == '/';
	xml->next_attribute = rest;
	xml->attributes_end = closes ? rest : end - xml->single;
	xml->at = end + 1;
	xml->depth += closes ? -1 : 1;
	return closes ? VEHICLE_XML_CLOSE : VEHICLE_XML_OPEN;
}

enum vehicle_xml_event vehicle_xml_next(struct vehicle_xml *xml)
{
	if (xml->single) {
		xml->single = false;
		xml->depth--;
		xml->next_attribute = xml->attributes_end;
		return VEHICLE_XML_CLOSE;
	}
	while (xml->at < xml->end) {
		bool whole = true;
		if (*xml->at == '\0')
			return VEHICLE_XML_BAD;
		if (*xml->at != '<')
			xml->at++;
		else if (begins(xml, "<!--"))
			xml->at += 4, whole = skip_past(xml, "-->");
		else if (begins(xml, "<![CDATA["))
			whole = skip_past(xml, "]]>");
		else if (begins(xml, "<?"))
			whole = skip_past(xml, "?>");
		else if (begins(xml, "<!"))
			whole = skip_past(xml, ">");
		else
			return take_tag(xml);
		if (!whole)
			return VEHICLE_XML_BAD;
	}
	return xml->depth == 0 ? VEHICLE_XML_DONE : VEHICLE_XML_BAD;
}

bool vehicle_xml_attribute(struct vehicle_xml *xml, struct vehicle_xml_attribute *out)
{
	const char *at = xml->next_attribute, *end = xml->attributes_end;
	while (at < end && *at != '=')
		at++;
	const char *last = at;
	while (last > xml->next_attribute && is_space(last[-1]))
		last--;
	const char *name = last;
	while (name > xml->next_attribute && !is_space(name[-1]) && name[-1] != '"' && name[-1] != '\'')
		name--;
	for (at += at < end; at < end && is_space(*at);)
		at++;
	const char *stop = at < end && (*at == '"' || *at == '\'') ? memchr(at + 1, *at, (size_t)(end - at - 1)) : NULL;
	xml->next_attribute = stop != NULL ? stop + 1 : end;
	if (stop == NULL)
		return false;
	*out = (struct vehicle_xml_attribute){name, at + 1, (size_t)(last - name), (size_t)(stop - at - 1)};
	return true;
}
