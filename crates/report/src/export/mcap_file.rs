//! MCAP: every message is JSON, with its schema in the file. Times are in ns since the start of the run.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::path::Path;

use cable_robot_files::read_text;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, WriteOptions, Writer};
use serde::Serialize;

use super::foxglove::{FrameTransform, Level, Log, PoseInFrame, SceneUpdate, Schema, Time};
use super::scene::{BASE, Scene, pose, pose_of};
use super::variables::{Group, groups};
use super::{ExportError, Failure, whole};
use crate::events::{self, EVENTS_CSV, Event, Kind};
use crate::run_folder::{RUN_CSV, RUN_JSON, RunFolder, RunFolderError, RunInfo};
use crate::table::CsvRows;

/// The robot is drawn at most so often, ns: a screen shows no more.
const BETWEEN_PICTURES: u64 = 10_000_000;

const JSON: &str = "json";
const JSON_SCHEMA: &str = "jsonschema";

/// Poses that are shown beside the platform, where the run has them: topic and variable.
const POSES: [(&str, &str); 2] = [("/goal", "controller.goalPose"), ("/set_point", "controller.setPoint")];

/// Writes a run folder, with the events of a rig, as MCAP; how many rows it has. `run.csv` is read through a reader of its own.
///
/// # Errors
/// [`ExportError`]; the file that stood there is then untouched.
pub fn mcap<R: Read>(
    folder: &Path,
    file: &Path,
    reader: impl FnOnce(File) -> R,
) -> Result<usize, ExportError> {
    let csv = folder.join(RUN_CSV);
    let wrong = |reason| RunFolderError::Csv { path: csv.clone(), reason };
    let (info, rows) = RunFolder::open(folder)?;
    let json = read_json(folder)?;
    let events = events::read(folder)?;
    whole(file, |out| {
        let mut rows = CsvRows::begin(reader(rows)).map_err(wrong)?;
        let mut table = rows.empty();
        let scene = Scene::new(&info, table.names()).map_err(wrong)?;
        let mut topics = Topics::begin(NoSeek::new(out), scene, &info, table.names())?;
        let mut waiting = events.iter().peekable();
        let mut count = 0;
        while rows.next(&mut table).map_err(wrong)? {
            let row = table.last_row();
            while let Some(event) = waiting.next_if(|event| event.time <= row[0]) {
                topics.event(event, nanoseconds(event.time, &folder.join(EVENTS_CSV))?)?;
            }
            topics.row(&row, nanoseconds(row[0], &csv)?)?;
            table.keep_last();
            count += 1;
        }
        topics.last_picture(&table.last_row())?;
        for event in waiting {
            topics.event(event, nanoseconds(event.time, &folder.join(EVENTS_CSV))?)?;
        }
        topics.end(&info, json)?;
        Ok(count)
    })
}

fn read_json(folder: &Path) -> Result<String, RunFolderError> {
    let path = folder.join(RUN_JSON);
    read_text(&path).map_err(|reason| RunFolderError::Read { path, reason })
}

fn nanoseconds(time: f64, path: &Path) -> Result<u64, ExportError> {
    if time < 0.0 {
        return Err(ExportError::Time { path: path.to_owned(), time });
    }
    Ok((time * 1e9).round() as u64)
}

/// A topic's number and the time of its last message, ns.
type Channel = u16;

/// The file, and what goes into it.
struct Topics<'a, W: Write + Seek> {
    file: Writer<W>,
    scene: Scene<'a>,
    groups: Vec<(Channel, Group)>,
    world: Channel,
    platform: Channel,
    outlines: Channel,
    cables: Channel,
    events: Option<Channel>,
    /// Columns, and what the last message says.
    poses: Vec<(Channel, [usize; 6], Option<[f64; 6]>)>,
    /// When the robot was drawn last, ns.
    drawn: Option<u64>,
    /// Of the last row, ns.
    now: u64,
    message: Vec<u8>,
}

impl<'a, W: Write + Seek> Topics<'a, W> {
    /// Of a run with these columns.
    fn begin(out: W, scene: Scene<'a>, info: &RunInfo, names: &[String]) -> Result<Self, Failure> {
        let options = WriteOptions::new().compression(None).library(program(info)).disable_seeking(true);
        let mut file = options.create(out)?;
        let mut of_group = |group: Group| {
            let (name, schema) = (format!("cable_robot.{}", group.name), group.schema().to_string());
            let schema = file.add_schema(&name, JSON_SCHEMA, schema.as_bytes())?;
            let topic = format!("/{}", group.name);
            Ok::<_, Failure>((file.add_channel(schema, &topic, JSON, &BTreeMap::new())?, group))
        };
        let groups = groups(names).into_iter().map(&mut of_group).collect::<Result<_, _>>()?;
        let poses = POSES.iter().filter_map(|(topic, name)| Some((topic, pose(names, name).ok()?)));
        let poses = poses.map(|(topic, places)| {
            Ok::<_, Failure>((channel::<PoseInFrame, W>(&mut file, topic)?, places, None))
        });
        let poses = poses.collect::<Result<_, _>>()?;
        Ok(Self {
            scene,
            groups,
            poses,
            world: channel::<FrameTransform, W>(&mut file, "/world")?,
            platform: channel::<FrameTransform, W>(&mut file, "/platform")?,
            outlines: channel::<SceneUpdate, W>(&mut file, "/outlines")?,
            cables: channel::<SceneUpdate, W>(&mut file, "/cables")?,
            events: None,
            drawn: None,
            now: 0,
            message: vec![],
            file,
        })
    }

    fn row(&mut self, row: &[f64], now: u64) -> Result<(), Failure> {
        self.now = now;
        if self.drawn.is_none() {
            self.write(self.world, now, &self.scene.world(Time::of(now)))?;
            self.write(self.outlines, now, &self.scene.outlines(Time::of(now)))?;
        }
        if self.drawn.is_none_or(|drawn| now - drawn >= BETWEEN_PICTURES) {
            self.picture(row)?;
        }
        for k in 0..self.poses.len() {
            let (channel, places, last) = self.poses[k];
            let pose = pose_of(places, row);
            let here: [f64; 6] = pose.0.into();
            if last != Some(here) {
                let message = PoseInFrame { timestamp: Time::of(now), frame_id: BASE, pose: (&pose).into() };
                self.write(channel, now, &message)?;
                self.poses[k].2 = Some(here);
            }
        }
        let groups = std::mem::take(&mut self.groups);
        for (channel, group) in &groups {
            self.write(*channel, now, &group.message(row))?;
        }
        self.groups = groups;
        Ok(())
    }

    /// Draws the robot.
    fn picture(&mut self, row: &[f64]) -> Result<(), Failure> {
        let (now, timestamp) = (self.now, Time::of(self.now));
        self.write(self.platform, now, &self.scene.platform(row, timestamp))?;
        self.write(self.cables, now, &self.scene.cables(row, timestamp))?;
        self.drawn = Some(now);
        Ok(())
    }

    /// Draws the robot as it ends, unless it is drawn already.
    fn last_picture(&mut self, row: &[f64]) -> Result<(), Failure> {
        if self.drawn == Some(self.now) { Ok(()) } else { self.picture(row) }
    }

    fn event(&mut self, event: &Event, time: u64) -> Result<(), Failure> {
        let channel = match self.events {
            Some(channel) => channel,
            None => *self.events.insert(channel::<Log, W>(&mut self.file, "/events")?),
        };
        let level = match event.kind {
            Kind::State | Kind::Goal => Level::Info,
            Kind::Refused => Level::Warning,
            Kind::Fault => Level::Error,
        };
        let message = Log {
            timestamp: Time::of(time),
            level: level as u32,
            message: format!("{}: {}", event.kind.name(), event.text),
            name: "can-bridge",
            file: "",
            line: 0,
        };
        self.write(channel, time, &message)
    }

    fn write(&mut self, channel_id: Channel, time: u64, message: &impl Serialize) -> Result<(), Failure> {
        self.message.clear();
        serde_json::to_writer(&mut self.message, message).map_err(|error| Failure::Written(error.into()))?;
        let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        Ok(self.file.write_to_known_channel(&header, &self.message)?)
    }

    /// Closes the file with what was run.
    fn end(mut self, info: &RunInfo, json: String) -> Result<(), Failure> {
        let texts = [("title", &info.title), ("rig", &info.rig), ("program", &program(info))];
        let metadata = texts.map(|(name, text)| (name.to_owned(), text.clone())).into();
        self.file.write_metadata(&Metadata { name: "run".to_owned(), metadata })?;
        self.file.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: RUN_JSON.to_owned(),
            media_type: "application/json".to_owned(),
            data: Cow::Owned(json.into_bytes()),
        })?;
        self.file.finish()?;
        Ok(())
    }
}

/// Which program made the run.
fn program(info: &RunInfo) -> String {
    format!("cable-robot {}", info.program_version)
}

/// A topic with a schema of Foxglove's.
fn channel<M: Schema, W: Write + Seek>(file: &mut Writer<W>, topic: &str) -> Result<Channel, Failure> {
    let schema = file.add_schema(M::NAME, JSON_SCHEMA, &M::json_schema_text())?;
    Ok(file.add_channel(schema, topic, JSON, &BTreeMap::new())?)
}
