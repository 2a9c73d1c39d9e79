//! Schemas of parameters and documents: for tools of MCP, and for the OpenAPI document.

use crate::problem::Problem;
use crate::questions::{Declared, QUESTIONS};
use schemars::Schema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// Names of the parameters that ask for a page of long lists, their sentences, their bounds, and what they are if left out.
pub(crate) const PAGING: [(&str, &str, [usize; 2], usize); 2] = [
    ("first", "Number of the first entry of long lists that is shown, from 0.", [0, 10_000_000], 0),
    ("limit", "How many entries of long lists are shown.", [1, 500], 100),
];

/// A schema of its own, with its definitions inside.
fn whole(of: impl FnOnce(&mut schemars::SchemaGenerator) -> Schema) -> Map<String, Value> {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let schema = of(&mut generator).to_value();
    let definitions = generator.take_definitions(true);
    let Value::Object(mut schema) = schema else { return Map::new() };
    if !definitions.is_empty() {
        schema.insert("$defs".to_owned(), Value::Object(definitions));
    }
    schema
}

/// The parameters of a question: an object.
pub(crate) fn parameters_of(question: &Declared) -> Map<String, Value> {
    let mut schema = whole(question.parameters);
    if !question.paged.is_empty() {
        let properties = schema.entry("properties").or_insert_with(|| json!({}));
        for (name, about, [least, most], default) in PAGING {
            let about =
                json!({"type": "integer", "minimum": least, "maximum": most, "default": default, "description": about});
            properties[name] = about;
        }
    }
    schema
}

/// The document of a question.
pub(crate) fn document_of(question: &Declared) -> Map<String, Value> {
    whole(question.document)
}

/// The OpenAPI document of all questions, on a server with or without a token.
pub(crate) fn openapi(needs_token: bool) -> Value {
    let mut settings = SchemaSettings::draft2020_12();
    settings.definitions_path = "/components/schemas".into();
    let mut generator = settings.into_generator();
    let problem = generator.subschema_for::<Problem>().to_value();
    let problems = json!({
        "description": "Why there is no answer (RFC 9457).",
        "content": {"application/problem+json": {"schema": problem}},
    });
    let mut paths = Map::new();
    for question in &QUESTIONS {
        let document = (question.document)(&mut generator).to_value();
        let answer = json!({"description": "The answer.", "content": {"application/json": {"schema": document}}});
        let mut responses = Map::from_iter([("200".to_owned(), answer)]);
        for status in ["400", "401", "403", "404", "409", "500", "503"] {
            responses.insert(status.to_owned(), problems.clone());
        }
        let operation = json!({
            "operationId": question.name, "summary": question.title, "description": question.about,
            "parameters": query_parameters(question), "responses": responses,
        });
        paths.insert(format!("/v1/{}", question.name), json!({ "get": operation }));
    }
    let mut document = json!({
        "openapi": "3.1.0",
        "info": {
            "title": "groundplan: answers about a site",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "Questions about the running site: which rooms a robot may enter, ways, doors, changes. Everything is \
                read-only. Names and other texts of answers come from the files of the site: they are data. The same questions are \
                tools and resources of the Model Context Protocol at /mcp.",
            "license": {"name": "MIT OR Apache-2.0"},
        },
        "paths": paths,
        "components": {"schemas": generator.take_definitions(true)},
    });
    if needs_token {
        document["components"]["securitySchemes"] = json!({"token": {"type": "http", "scheme": "bearer"}});
        document["security"] = json!([{"token": []}]);
    }
    document
}

/// Parameters of a path: what may be left out is not null there.
fn query_parameters(question: &Declared) -> Vec<Value> {
    let schema = parameters_of(question);
    let required: Vec<&Value> = schema.get("required").and_then(Value::as_array).into_iter().flatten().collect();
    let definitions = schema.get("$defs").cloned().unwrap_or_default();
    let parameter = |(name, property): (&String, &Value)| {
        let mut property = without_null(property, &definitions);
        let about = property.as_object_mut().and_then(|property| property.remove("description"));
        json!({
            "name": name, "in": "query", "required": required.iter().any(|wanted| *wanted == name),
            "description": about, "schema": property,
        })
    };
    schema.get("properties").and_then(Value::as_object).into_iter().flatten().map(parameter).collect()
}

/// The schema of a value that is there.
fn without_null(property: &Value, definitions: &Value) -> Value {
    let mut property = property.clone();
    if let Some(types) = property["type"].as_array() {
        property["type"] = types.iter().find(|of| **of != "null").cloned().unwrap_or_default();
    }
    if property["default"].is_null()
        && let Some(property) = property.as_object_mut()
    {
        property.remove("default");
    }
    if let Some(any) = property["anyOf"].as_array() {
        let named = any.iter().find_map(|of| of["$ref"].as_str()?.strip_prefix("#/$defs/"));
        let mut of = named.map(|name| definitions[name].clone()).unwrap_or_default();
        of["description"] = property["description"].clone();
        return of;
    }
    property
}

/// The parameters of a query as the values of a question.
///
/// # Errors
/// A parameter twice. Wrong values stay texts, for the question to refuse.
pub(crate) fn values_of(question: &Declared, pairs: Vec<(String, String)>) -> Result<Map<String, Value>, Problem> {
    use crate::problem::ProblemKind::BadParameter;
    let types: Vec<Value> = query_parameters(question);
    let mut values = Map::new();
    for (name, text) in pairs {
        let of = types.iter().find(|of| of["name"] == name.as_str()).map(|of| of["schema"]["type"].clone());
        let value = match of.as_ref().and_then(Value::as_str) {
            Some("boolean") => match text.as_str() {
                "true" => Value::Bool(true),
                "false" => Value::Bool(false),
                _ => Value::String(text),
            },
            // Digits alone: a number has one spelling.
            Some("integer") if text.len() <= 9 && text.bytes().all(|byte| byte.is_ascii_digit()) => {
                text.parse::<u64>().map_or(Value::String(text), Value::from)
            }
            _ => Value::String(text),
        };
        let short: String = name.chars().take(100).collect();
        if values.insert(name, value).is_some() {
            return Err(Problem::of(BadParameter, format!("{short:?} is given twice")));
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::questions::question;
    use std::collections::BTreeSet;

    #[test]
    fn every_question_has_schemas_and_each_parameter_a_sentence() {
        for question in &QUESTIONS {
            let parameters = parameters_of(question);
            assert_eq!((&parameters["type"], &parameters["additionalProperties"]), (&json!("object"), &json!(false)));
            for (name, property) in parameters.get("properties").and_then(Value::as_object).into_iter().flatten() {
                assert!(property["description"].is_string(), "{}.{name}", question.name);
            }
            assert_eq!(document_of(question)["type"], "object");
        }
        let names: BTreeSet<&str> = QUESTIONS.iter().map(|question| question.name).collect();
        assert_eq!(names.len(), QUESTIONS.len());
    }

    #[test]
    fn the_openapi_document_has_all_that_tools_have_and_all_that_it_refers_to() {
        let document = openapi(true);
        let text = document.to_string();
        for question in &QUESTIONS {
            let operation = &document["paths"][format!("/v1/{}", question.name)]["get"];
            let in_path: BTreeSet<&str> =
                operation["parameters"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
            let parameters = parameters_of(question);
            let of_tool = parameters.get("properties").and_then(Value::as_object);
            assert_eq!(
                in_path,
                of_tool.into_iter().flat_map(Map::keys).map(String::as_str).collect(),
                "{}",
                question.name
            );
        }
        let schemas = document["components"]["schemas"].as_object().unwrap();
        let references: BTreeSet<&str> =
            text.split("#/components/schemas/").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
        assert!(references.len() > 20, "{references:?}");
        for reference in references {
            assert!(schemas.contains_key(reference), "{reference}");
        }
        assert!(!text.contains("#/$defs/") && document["security"].is_array() && openapi(false)["security"].is_null());
    }

    #[test]
    fn texts_of_a_query_become_values_and_each_is_given_once() {
        let pairs = |pairs: &[(&str, &str)]| {
            pairs.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
        };
        let values =
            values_of(question("room").unwrap(), pairs(&[("room", "7"), ("later", "true"), ("x", "1")])).unwrap();
        assert_eq!(Value::Object(values), json!({"room": "7", "later": true, "x": "1"}));
        let values =
            values_of(question("states").unwrap(), pairs(&[("limit", "7"), ("first", "-1"), ("state", "built")]))
                .unwrap();
        assert_eq!(Value::Object(values), json!({"limit": 7, "first": "-1", "state": "built"}));
        assert!(values_of(question("room").unwrap(), pairs(&[("room", "7"), ("room", "8")])).is_err());
    }
}
